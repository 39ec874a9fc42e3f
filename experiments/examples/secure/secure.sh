#!/bin/sh
# Certificates and one Zenoh configuration for every peer of a csat fleet: docs/processes.md.
#
#     secure.sh DIR UAVS [ADDRESS]...
#
# makes DIR with ca.pem, a certificate and a key for the world, each UAV and spectators, and zenoh.json5.
# Addresses are those of the computers where peers listen (default: 127.0.0.1), IPv4 or names.
# On another computer a peer needs zenoh.json5, ca.pem and its own NAME.pem and NAME.key; ca.key, which
# makes further peers, belongs to none.
set -eu

[ $# -ge 2 ] || { sed -n '2,9s/^# \{0,1\}//p' "$0" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
dir=$1 uavs=$2
shift 2
[ $# -gt 0 ] || set -- 127.0.0.1
case $uavs in '' | *[!0-9]*) echo "secure.sh: got $uavs UAVs, expected a number" >&2; exit 2 ;; esac
[ ! -e "$dir" ] || { echo "secure.sh: $dir exists" >&2; exit 2; }
umask 077
mkdir -p "$dir"

names="DNS:localhost"
for address; do
  case $address in
    *[!0-9.]*) names="$names,DNS:$address" ;;
    *) names="$names,IP:$address" ;;
  esac
done

days=365
key="-newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes"
# shellcheck disable=SC2086
openssl req -x509 $key -days "$days" -subj "/CN=csat fleet" -keyout "$dir/ca.key" -out "$dir/ca.pem" \
  -addext basicConstraints=critical,CA:TRUE -addext keyUsage=critical,keyCertSign 2>/dev/null

# Its common name is what access control knows a peer by.
certificate() {
  # shellcheck disable=SC2086
  openssl req $key -subj "/CN=$1" -keyout "$dir/$1.key" -out "$dir/$1.csr" 2>/dev/null
  printf '%s\n' "subjectAltName=$names" basicConstraints=CA:FALSE \
    extendedKeyUsage=serverAuth,clientAuth > "$dir/$1.ext"
  openssl x509 -req -in "$dir/$1.csr" -days "$days" -CA "$dir/ca.pem" -CAkey "$dir/ca.key" \
    -extfile "$dir/$1.ext" -out "$dir/$1.pem" 2>/dev/null
  rm "$dir/$1.csr" "$dir/$1.ext"
}

rules="" subjects="" policies=""
peer() {
  certificate "$1"
  subjects="$subjects      { id: \"$1\", cert_common_names: [\"$1\"] },
"
}
peer world
peer spectator
uav=0
while [ "$uav" -lt "$uavs" ]; do
  peer "uav-$uav"
  rules="$rules$(sed "s/UAV/$uav/g" "$here/uav-rules.json5")
"
  policies="$policies      { rules: [\"out\", \"look\", \"uav-$uav says\", \"uav-$uav asks\"], subjects: [\"uav-$uav\"] },
"
  uav=$((uav + 1))
done

while IFS= read -r line; do
  case $line in
    *@rules@*) printf '%s' "$rules" ;;
    *@subjects@*) printf '%s' "$subjects" ;;
    *@policies@*) printf '%s' "$policies" ;;
    *) printf '%s\n' "$line" ;;
  esac
done < "$here/zenoh.json5.in" > "$dir/zenoh.json5"
