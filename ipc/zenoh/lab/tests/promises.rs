//! Each promise in its short form, as `taut-zenoh-lab promises` measures it; and that a lab leaves nothing
//! behind.

use std::process::{Command, Stdio};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Promises are measured one after another, so that they do not disturb each other.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

fn lab(name: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_taut-zenoh-lab"));
    command.args(["promises", "--only", name]);
    command
}

fn is_kept(name: &str) {
    let _alone = ONE_AT_A_TIME
        .lock()
        .unwrap_or_else(PoisonError::into_inner);
    let output = lab(name).output().unwrap();
    let [said, errors] =
        [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    println!("{said}{errors}");
    assert!(output.status.success(), "{name}: {}", output.status);
}

macro_rules! promises {
    ($($name:ident)*) => {
        $(
            #[test]
            fn $name() {
                is_kept(stringify!($name));
            }
        )*
    };
}

promises! { links answers languages later overhead cancelling deaths cuts felt routers far scenes mutated stopped }

/// Namespaces of labs, as `ip` lists them.
fn namespaces_of(pid: u32) -> usize {
    let output = Command::new("ip")
        .args(["netns", "list"])
        .output();
    let text = output.map_or(Vec::new(), |output| output.stdout);
    let prefix = format!("taut-lab-{pid}-");
    String::from_utf8_lossy(&text)
        .lines()
        .filter(|line| line.starts_with(&prefix))
        .count()
}

#[test]
fn what_a_killed_lab_leaves_the_next_one_removes() {
    let mut killed = lab("links")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let pid = killed.id();
    let end = Instant::now() + Duration::from_secs(20);
    // It ends where it cannot have hosts.
    while namespaces_of(pid) < 2 && killed.try_wait().unwrap().is_none() && Instant::now() < end {
        std::thread::sleep(Duration::from_millis(5));
    }
    killed.kill().unwrap();
    killed.wait().unwrap();
    is_kept("links");
    assert_eq!(namespaces_of(pid), 0);
}
