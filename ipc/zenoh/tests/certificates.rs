//! Mutual TLS and access control with the configurations in `config/zenoh`.
#![allow(missing_docs)]

mod world;

use rcgen::{BasicConstraints, CertificateParams, CertifiedIssuer, DnType, IsCa, KeyPair};
use std::path::{Path, PathBuf};
use taut_ipc::wire::{Code, Mode};
use taut_zenoh::{Network, Zenoh};
use world::{NAME, World, free_port, request, told};

type Authority = CertifiedIssuer<'static, KeyPair>;

fn authority() -> Authority {
    let mut params = CertificateParams::new(Vec::new()).unwrap();
    params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
    let key = KeyPair::generate().unwrap();
    CertifiedIssuer::self_signed(params, key).unwrap()
}

/// Writes `file.pem` and `file.key` for somebody of this name.
fn certify(authority: &Authority, folder: &Path, file: &str, name: &str) {
    let mut params = CertificateParams::new(vec!["localhost".to_owned()]).unwrap();
    params
        .distinguished_name
        .push(DnType::CommonName, name);
    let key = KeyPair::generate().unwrap();
    let certificate = params.signed_by(&key, authority).unwrap();
    let write = |ending: &str, text: String| {
        std::fs::write(folder.join(format!("{file}.{ending}")), text).unwrap();
    };
    write("pem", certificate.pem());
    write("key", key.serialize_pem());
}

/// A shipped configuration with these files and this port.
fn configured(folder: &Path, file: &str, port: u16) -> PathBuf {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../config/zenoh")
        .join(file);
    let text = std::fs::read_to_string(shipped).unwrap();
    let text = text
        .replace("/etc/taut/zenoh", folder.to_str().unwrap())
        .replace("0.0.0.0:7447", &format!("127.0.0.1:{port}"))
        .replace("gateway:7447", &format!("localhost:{port}"));
    let path = folder.join(file);
    std::fs::write(&path, text).unwrap();
    path
}

fn with(config: PathBuf) -> Network {
    Network {
        config: Some(config),
        ..Network::default()
    }
}

fn codes(network: &Network) -> Vec<Code> {
    let zenoh = Zenoh::connect(network).unwrap();
    let told = told(&zenoh, &request(Mode::Check, 1));
    told.into_iter().map(|(code, _)| code).collect()
}

#[test]
fn only_planners_that_are_named_get_answers() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let authority = authority();
    let port = free_port();
    std::fs::write(folder.join("ca.pem"), authority.pem()).unwrap();
    certify(&authority, folder, "gateway", "gateway");
    let gateway = with(configured(folder, "gateway.json5", port));
    let _world = World::with(NAME, gateway, format!("tls/localhost:{port}"));
    let planner = with(configured(folder, "planner.json5", port));
    for (name, code) in [
        ("planner-1", Code::Success),
        ("somebody", Code::DaemonLost),
        ("planner-2", Code::Success),
    ] {
        certify(&authority, folder, "planner", name);
        // The first request may be before the link.
        let codes = codes(&planner);
        assert_eq!(codes, [code], "{name}");
    }
    certify(&self::authority(), folder, "planner", "planner-1");
    assert_eq!(codes(&planner), [Code::DaemonLost], "another authority");
}
