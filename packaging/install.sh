#!/bin/sh
# Installs csat with its manual pages and its completions for bash, zsh and fish.
#
#   packaging/install.sh                    builds it and installs below ~/.local
#   PREFIX=/usr/local packaging/install.sh  below another folder
#   packaging/install.sh path/to/csat       a program that is there already
#
# DESTDIR is put in front of all paths, as packagers expect.
set -eu
repository="$(cd "$(dirname "$0")/.." && pwd)"
root="${DESTDIR:-}${PREFIX:-$HOME/.local}"

if [ $# -eq 0 ]; then
  cargo build --release --locked --manifest-path "$repository/Cargo.toml"
  set -- "${CARGO_TARGET_DIR:-$repository/target}/release/csat"
fi

# No file is half there: each is written beside its place and then moved.
place() {
  mkdir -p "$(dirname "$root/$1")"
  cat > "$root/$1.new"
  mv -f "$root/$1.new" "$root/$1"
}

mkdir -p "$root/bin"
install -m 755 "$1" "$root/bin/csat"
"$1" completions bash | place share/bash-completion/completions/csat
"$1" completions zsh | place share/zsh/site-functions/_csat
"$1" completions fish | place share/fish/vendor_completions.d/csat.fish
"$1" man --out "$root/share/man/man1"
echo "csat is in $root/bin"
