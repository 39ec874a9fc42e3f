//! The job array of docs/sweeps.md, run by a real Slurm: a cluster of one node, on loopback.

#![cfg(unix)]

mod common;

use std::net::{Ipv4Addr, TcpListener};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use common::docs::{blocks, root};
use common::fleet::{signal, wait_until};
use common::sweeps::{done, results, runs};
use common::{SMALL, names, read, scratch, skipped, text};

/// What the array flies, and a plain sweep that must have the same results.
const SWEEP: &[&str] = &["city", "--vary", "netem.radio.range_m=25,inf", "--seeds", "1..2"];

/// A controller, a node and the daemon that signs their messages, which end with this value.
struct Cluster {
    folder: PathBuf,
    daemons: Vec<Child>,
}

impl Cluster {
    /// A cluster in a folder; `None`, said loudly, where Slurm is not installed.
    fn start(folder: &Path) -> Option<Self> {
        for (tool, version) in [("munged", "--version"), ("slurmctld", "-V"), ("slurmd", "-V")] {
            if Command::new(tool).arg(version).stdout(Stdio::null()).status().is_err() {
                skipped(&format!("there is no {tool}; `apt-get install slurm-wlm munge`"));
                return None;
            }
        }
        std::fs::write(folder.join("slurm.conf"), configuration(folder)).unwrap();
        let key = folder.join("munge.key");
        std::fs::write(&key, [7; 128]).unwrap();
        std::fs::set_permissions(&key, std::fs::Permissions::from_mode(0o400)).unwrap();
        let mut cluster = Self { folder: folder.to_owned(), daemons: Vec::new() };
        let file = |option: &str, name: &str| format!("--{option}={}", folder.join(name).display());
        let files = [("key-file", "munge.key"), ("socket", "munge.sock"), ("seed-file", "seed")]
            .map(|(option, name)| file(option, name));
        let more = [file("pid-file", "munged.pid"), file("log-file", "munged.log")];
        // By --force a folder that only its user can enter will do.
        cluster.daemon(
            "munged",
            &[&["--foreground", "--force"].map(str::to_owned)[..], &files, &more].concat(),
        );
        wait_until("munged answers", || folder.join("munge.sock").exists());
        cluster.daemon("slurmctld", &["-D".to_owned()]);
        cluster.daemon("slurmd", &["-D".to_owned()]);
        wait_until("the node is idle", || {
            let said =
                cluster.command("sinfo").args(["--noheader", "--format=%T"]).output().unwrap();
            text(&said.stdout).trim() == "idle"
        });
        Some(cluster)
    }

    /// A command of this cluster, with `csat` in its path.
    fn command(&self, program: &str) -> Command {
        let csat = Path::new(env!("CARGO_BIN_EXE_csat")).parent().unwrap();
        let path = std::env::var("PATH").unwrap();
        let mut command = Command::new(program);
        command.current_dir(&self.folder).env_remove("RUST_LOG");
        command.env("PATH", format!("{}:{path}", csat.display()));
        command.env("SLURM_CONF", self.folder.join("slurm.conf"));
        command
    }

    /// Starts a daemon, which writes to a file of its name.
    fn daemon(&mut self, program: &str, arguments: &[String]) {
        let log = std::fs::File::create(self.folder.join(format!("{program}.out"))).unwrap();
        let mut command = self.command(program);
        command.args(arguments).stdout(log.try_clone().unwrap()).stderr(log);
        self.daemons.push(command.spawn().unwrap_or_else(|e| panic!("{program}: {e}")));
    }

    /// Submits a job array and waits for its end; what its tasks wrote, in their order.
    fn run(&self, script: &str, array: &str) -> String {
        let mut sbatch = self.command("timeout");
        sbatch.args(["300", "sbatch"]);
        sbatch.args([
            "--wait",
            "--output=task-%a.txt",
            "--cpus-per-task=1",
            "--array",
            array,
            script,
        ]);
        let output = sbatch.output().unwrap();
        let tasks = names(&self.folder).into_iter().filter(|name| name.starts_with("task-"));
        let said: String = tasks.map(|name| read(&self.folder.join(name))).collect();
        assert!(output.status.success(), "{}{said}", text(&output.stderr));
        said
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        for mut daemon in self.daemons.drain(..).rev() {
            signal(daemon.id(), "-TERM");
            let _ = daemon.wait();
        }
        if std::thread::panicking() {
            let logs = names(&self.folder).into_iter().filter(|name| name.ends_with(".out"));
            logs.for_each(|name| eprintln!("{name}:\n{}", read(&self.folder.join(&name))));
        }
    }
}

/// The configuration of a cluster of this machine, which runs as the user of the test.
fn configuration(folder: &Path) -> String {
    let said = |program: &str, argument: &str| {
        let output = Command::new(program).arg(argument).output().unwrap();
        text(&output.stdout).trim().to_owned()
    };
    let (user, name) = (said("id", "-un"), said("uname", "-n"));
    let host = name.split('.').next().unwrap();
    // Two sockets at once, so that the ports differ.
    let sockets = [(); 2].map(|()| TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap());
    let [controller, node] = sockets.map(|socket| socket.local_addr().unwrap().port());
    let at = folder.display();
    format!(
        "ClusterName=loopback\n\
         SlurmctldHost={host}(127.0.0.1)\n\
         SlurmctldPort={controller}\n\
         SlurmdPort={node}\n\
         CommunicationParameters=NoCtldInAddrAny,NoInAddrAny\n\
         AuthType=auth/munge\n\
         AuthInfo=socket={at}/munge.sock\n\
         SlurmUser={user}\n\
         SlurmdUser={user}\n\
         StateSaveLocation={at}/state\n\
         SlurmdSpoolDir={at}/spool\n\
         SlurmctldPidFile={at}/slurmctld.pid\n\
         SlurmdPidFile={at}/slurmd.pid\n\
         ProctrackType=proctrack/pgid\n\
         TaskPlugin=task/none\n\
         SelectType=select/cons_tres\n\
         SelectTypeParameters=CR_Core\n\
         SlurmdParameters=config_overrides\n\
         NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN\n\
         PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP\n"
    )
}

/// The script of the docs, with a sweep that takes a moment.
fn script() -> String {
    let sweeps = read(&root().join("docs/sweeps.md"));
    let mut scripts = blocks(&sweeps, "sh").into_iter().map(|(_, lines)| lines.join("\n"));
    let mut script = scripts.find(|script| script.contains("#SBATCH")).expect("a job array");
    let small = SMALL.iter().map(|argument| format!(" '{argument}'")).collect::<String>();
    for (from, to) in [
        ("range_m=25,50,100,200,400,inf ", "range_m=25,inf ".to_owned()),
        (" --seeds 1..100 ", format!(" --seeds 1..2{small} ")),
    ] {
        assert!(script.contains(from), "{from}: {script}");
        script = script.replace(from, &to);
    }
    script
}

#[test]
fn the_job_array_of_the_docs_makes_the_sweep_of_one_process() {
    let folder = scratch();
    let Some(cluster) = Cluster::start(folder.path()) else { return };
    std::fs::write(folder.path().join("range.sh"), script()).unwrap();
    let said = cluster.run("range.sh", "1-3");
    assert!(said.contains("4 runs: 4 flown"), "{said}");
    done(folder.path(), &[SWEEP, &["--out", "plain"]].concat());
    let of = |name: &str| folder.path().join(name);
    assert_eq!(results(&of("range")), results(&of("plain")));
    assert_eq!(runs(&of("range")), runs(&of("plain")));
    // A task that Slurm starts again finds its work done.
    let files =
        || names(&of("range/runs")).into_iter().map(|name| read(&of("range/runs").join(name)));
    let before: Vec<String> = files().collect();
    cluster.run("range.sh", "1-3");
    assert!(files().eq(before), "a run was flown again");
}
