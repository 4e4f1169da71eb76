//! The layouts never change by accident, and no bytes from the other side panic.

use proptest::prelude::*;
use taut_ipc::control::{self, ControlReply, ControlRequest, FileId, RobotSource};
use taut_ipc::limits::{CONTROL_MAX, GIVE_MAX, MAX_TEXT};
use taut_ipc::wire::*;

/// Bytes aligned like a payload in shared memory.
fn aligned(bytes: &[u8]) -> Vec<u64> {
    let mut words = vec![0; bytes.len().div_ceil(8)];
    bytemuck::cast_slice_mut(&mut words)[..bytes.len()].copy_from_slice(bytes);
    words
}

fn request() -> RequestHeader {
    RequestHeader {
        wire_version: 1,
        header_len: 200,
        waypoints: 2,
        variables: 1,
        path: Section {
            offset: 0,
            count: 2,
        },
        ..RequestHeader::default()
    }
}

/// A header whose every 4 bytes hold their own index, little endian.
fn counted<H: bytemuck::Pod>() -> H {
    let mut header = H::zeroed();
    let words: &mut [u32] = bytemuck::cast_slice_mut(std::slice::from_mut(&mut header));
    (0..)
        .zip(words)
        .for_each(|(index, word)| *word = index);
    header
}

#[test]
fn golden_request_header() {
    let h: RequestHeader = counted();
    let two = |index: u64| index | (index + 1) << 32;
    assert_eq!((h.wire_version, h.header_len, h.request_id), (0, 1, two(2)));
    assert_eq!(h.listener_id, [two(4), two(6)]);
    assert_eq!((h.robot_id, h.scene_id), (two(8), two(10)));
    assert_eq!(
        (h.robot_hash, h.scene_hash, h.scene_version),
        (two(12), two(14), two(16))
    );
    assert_eq!(
        (h.layout_hash, h.mode, h.flags, h.priority, h.group),
        (two(18), 20, 21, 22, 23)
    );
    assert_eq!(
        (h.seed, h.deadline_ns, h.work_budget),
        (two(24), two(26), two(28))
    );
    assert_eq!(
        (h.clearance_m.to_bits(), h.waypoints, h.variables),
        (two(30), 32, 33)
    );
    assert_eq!(
        h.path,
        Section {
            offset: 34,
            count: 35
        }
    );
    assert_eq!(
        h.weights,
        Section {
            offset: 36,
            count: 37
        }
    );
    assert_eq!(
        h.fixed_waypoints,
        Section {
            offset: 38,
            count: 39
        }
    );
    assert_eq!(
        h.group_mask,
        Section {
            offset: 40,
            count: 41
        }
    );
    assert_eq!(
        h.held_values,
        Section {
            offset: 42,
            count: 43
        }
    );
    assert_eq!(
        h.constraints,
        Section {
            offset: 44,
            count: 45
        }
    );
    assert_eq!(
        h.timing,
        Section {
            offset: 46,
            count: 47
        }
    );
    assert_eq!(bytemuck::bytes_of(&h)[132..140], [33, 0, 0, 0, 34, 0, 0, 0]);
    assert_eq!(size_of::<RequestHeader>(), 200);
}

#[test]
fn golden_response_header() {
    let h: ResponseHeader = counted();
    let two = |index: u64| index | (index + 1) << 32;
    assert_eq!((h.wire_version, h.header_len, h.request_id), (0, 1, two(2)));
    assert_eq!((h.seq, h.status, h.code, h.retry_after_ms), (4, 5, 6, 7));
    assert_eq!((h.boot_id, h.robot_hash), (two(8), two(10)));
    assert_eq!(
        (h.scene_id, h.scene_hash, h.scene_version),
        (two(12), two(14), two(16))
    );
    assert_eq!(
        (h.termination, h.refusal_reason, h.flags, h.stage),
        (18, 19, 20, 21)
    );
    assert_eq!((h.waypoints, h.variables), (22, 23));
    assert_eq!(
        (h.length_before.to_bits(), h.length_after.to_bits()),
        (two(24), two(26))
    );
    assert_eq!(
        (h.lower_bound.to_bits(), h.clearance_m.to_bits()),
        (two(28), two(30))
    );
    assert_eq!(
        (h.floor_m.to_bits(), h.searched_m.to_bits()),
        (two(32), two(34))
    );
    assert_eq!(
        (h.iterations, h.work, h.queue_ns, h.compute_ns),
        (two(36), two(38), two(40), two(42))
    );
    assert_eq!(
        h.path,
        Section {
            offset: 44,
            count: 45
        }
    );
    assert_eq!(
        h.certificate,
        Section {
            offset: 46,
            count: 47
        }
    );
    assert_eq!(
        h.lowered_floors,
        Section {
            offset: 48,
            count: 49
        }
    );
    assert_eq!(
        h.holds,
        Section {
            offset: 50,
            count: 51
        }
    );
    assert_eq!(
        h.stages,
        Section {
            offset: 52,
            count: 53
        }
    );
    assert_eq!(
        h.pinched,
        Section {
            offset: 54,
            count: 55
        }
    );
    assert_eq!(
        h.refusal,
        Section {
            offset: 56,
            count: 57
        }
    );
    assert_eq!(
        h.certificate_head,
        Section {
            offset: 58,
            count: 59
        }
    );
    assert_eq!(
        h.names,
        Section {
            offset: 60,
            count: 61
        }
    );
    assert_eq!(
        h.message,
        Section {
            offset: 62,
            count: 63
        }
    );
    assert_eq!(
        h.reach,
        Section {
            offset: 64,
            count: 65
        }
    );
    assert_eq!(
        (h.pairs, h.warnings),
        (
            two(66),
            Section {
                offset: 68,
                count: 69
            }
        )
    );
    assert_eq!(
        h.turned_columns,
        Section {
            offset: 70,
            count: 71
        }
    );
    assert_eq!(
        [h.keeps, h.constraints, h.constraint_claims],
        [72, 74, 76].map(|offset| Section {
            offset,
            count: offset + 1
        })
    );
    assert_eq!((h.times, h.reserved), (78, 79));
    let places = h.trajectory;
    assert_eq!(
        [
            places.head,
            places.times,
            places.positions,
            places.velocities,
            places.accelerations,
            places.limits,
            places.used,
            places.floors,
            places.nearest
        ],
        [80, 82, 84, 86, 88, 90, 92, 94, 96].map(|offset| Section {
            offset,
            count: offset + 1
        })
    );
    assert_eq!(size_of::<ResponseHeader>(), 400);
}

#[test]
fn wire_md_is_current() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/WIRE.md");
    let text = document::document();
    if std::env::var_os("UPDATE_WIRE_MD").is_some() {
        std::fs::write(path, &text).unwrap();
    }
    let stored = std::fs::read_to_string(path).unwrap_or_default();
    assert!(
        stored == text,
        "WIRE.md is not current: UPDATE_WIRE_MD=1 cargo test -p taut-ipc wire_md"
    );
}

#[test]
fn numbers_and_codes_convert_both_ways() {
    for code in Code::ALL {
        assert_eq!(Code::try_from(i32::from(*code)), Ok(*code));
        assert!(code.is_retryable() == (code.exit_code() == 4), "{code}");
    }
    assert!(Code::try_from(0).is_err());
    for (mode, _) in Mode::ALL {
        assert_eq!(Mode::try_from(u32::from(*mode)), Ok(*mode));
    }
    assert!(Mode::try_from(Mode::ALL.len() as u32).is_err());
}

#[test]
fn malformed_requests_get_their_code() {
    let payload = aligned(&[0; 16]);
    let parse = |h: RequestHeader| RequestView::parse(h, bytemuck::cast_slice(&payload)).map(drop);
    assert_eq!(parse(request()), Ok(()));
    let cases: [(RequestHeader, Code); 13] = [
        (
            RequestHeader {
                wire_version: 2,
                ..request()
            },
            Code::MalformedRequest,
        ),
        (
            RequestHeader {
                header_len: 168,
                ..request()
            },
            Code::MalformedRequest,
        ),
        (
            RequestHeader {
                mode: Mode::ALL.len() as u32,
                ..request()
            },
            Code::MalformedRequest,
        ),
        (
            RequestHeader {
                flags: RequestFlags::ALL + 1,
                ..request()
            },
            Code::MalformedRequest,
        ),
        (
            RequestHeader {
                clearance_m: f64::NAN,
                ..request()
            },
            Code::MalformedRequest,
        ),
        (
            RequestHeader {
                clearance_m: -1.0,
                ..request()
            },
            Code::MalformedRequest,
        ),
        (
            RequestHeader {
                waypoints: 0,
                ..request()
            },
            Code::ResourceExhausted,
        ),
        (
            RequestHeader {
                waypoints: 1_000_000,
                ..request()
            },
            Code::ResourceExhausted,
        ),
        (
            RequestHeader {
                variables: u32::MAX,
                ..request()
            },
            Code::ResourceExhausted,
        ),
        (
            RequestHeader {
                path: Section {
                    offset: 8,
                    count: 2,
                },
                ..request()
            },
            Code::MalformedRequest,
        ),
        (
            RequestHeader {
                path: Section {
                    offset: 0,
                    count: 1,
                },
                ..request()
            },
            Code::MalformedRequest,
        ),
        (
            RequestHeader {
                fixed_waypoints: Section {
                    offset: 0,
                    count: 1,
                },
                ..request()
            },
            Code::MalformedRequest,
        ),
        (
            RequestHeader {
                constraints: Section {
                    offset: 0,
                    count: 64 * 1024 + 1,
                },
                ..request()
            },
            Code::ResourceExhausted,
        ),
    ];
    for (header, code) in cases {
        let error = parse(header).unwrap_err();
        assert_eq!(error.code(), code, "{error}");
        assert!(!error.to_string().contains('\n'));
    }
}

#[test]
fn a_full_response_reads_back() {
    let mut names = String::new();
    let hand = TextSpan::push(&mut names, "hand");
    let door = TextSpan::push(&mut names, "Tür");
    let requirement = RequirementRecord {
        names: [hand, door],
        ..Default::default()
    };
    let refusal = RefusalRecord {
        requirement,
        segment: 6,
        t: 0.437,
        amount: -0.0021,
        ..Default::default()
    };
    let nearest = HoldRecord {
        requirement,
        t: 0.25,
        ..Default::default()
    };
    let trajectory = TrajectorySections {
        head: Some(&TrajectoryRecord {
            stage: 2,
            bound_s: 1.5,
            ..Default::default()
        }),
        times_ns: &[0, 1, 2_000_000_001],
        positions: &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0],
        velocities: &[0.0, 0.0, 1.0, 1.5, 0.0, 0.0],
        accelerations: &[],
        limits: &[-1.0, 1.0, -2.0, 2.0, -3.0, 3.0, -4.0, 4.0],
        used: &[0.5, 1.0, 1.0, 0.0, 0.25, 0.75, 0.5, 2.0],
        lowered_floors: &[LoweredFloorRecord {
            requirement,
            floor: 5e-4,
        }],
        nearest: Some(&nearest),
    };
    let body = ResponseBody {
        trajectory,
        path: &[1.0, 2.0, 3.0, 4.0],
        certificate: &[CertificateSegment {
            clearance_m: 0.0118,
            intervals: 7,
            reserved: 0,
        }],
        lowered_floors: &[LoweredFloorRecord {
            requirement,
            floor: 2.5e-4,
        }],
        holds: &[HoldRecord {
            requirement,
            t: 0.5,
            ..Default::default()
        }],
        pinched: &[requirement],
        stages: &[StageRecord {
            stage: 4,
            gain: 1.5,
            ..Default::default()
        }],
        keeps: &[KeptRecord {
            tightest: HoldRecord {
                requirement,
                ..Default::default()
            },
            left: 0.25,
            asked: 0.5,
        }],
        constraints: "{}",
        constraint_claims: &[0.25, 0.375],
        reach: &[0.5, 0.25],
        turned_columns: &[TurnedColumn {
            column: 1,
            turns: -1,
        }],
        warnings: &[WarningRecord {
            kind: WarningKind::Cosmetic.into(),
            text: door,
            reserved: 0,
        }],
        refusal: Some(&refusal),
        certificate_head: Some(&CertificateHead {
            segments: 1,
            ..Default::default()
        }),
        names: &names,
        message: "one line",
    };
    let mut header = ResponseHeader {
        wire_version: 1,
        header_len: 400,
        code: 1,
        waypoints: 2,
        variables: 2,
        ..Default::default()
    };
    let bytes = body.lay_out(&mut header).unwrap();
    let mut payload = vec![0u64; bytes.div_ceil(8)];
    let payload: &mut [u8] = &mut bytemuck::cast_slice_mut(&mut payload)[..bytes];
    body.write(&header, payload);
    let view = ResponseView::parse(header, payload).unwrap();
    assert_eq!(view.path, body.path);
    assert_eq!(view.waypoint(1), Some(&[3.0, 4.0][..]));
    assert_eq!(view.waypoint(2), None);
    assert_eq!(
        (view.reach, view.turned_columns),
        (body.reach, body.turned_columns)
    );
    assert_eq!(view.refusal, Some(&refusal));
    assert_eq!(
        view.refusal
            .unwrap()
            .requirement
            .names(view.names),
        Ok(vec!["hand".to_owned(), "Tür".to_owned()])
    );
    assert_eq!(
        (
            view.certificate.len(),
            view.lowered_floors.len(),
            view.holds.len()
        ),
        (1, 1, 1)
    );
    assert_eq!((view.stages, view.pinched), (body.stages, body.pinched));
    assert_eq!(
        (view.keeps, view.constraints, view.constraint_claims),
        (body.keeps, body.constraints, body.constraint_claims)
    );
    assert_eq!(view.trajectory, trajectory);
    header.trajectory.velocities.count -= 1;
    assert_eq!(
        ResponseView::parse(header, payload)
            .unwrap_err()
            .code(),
        Code::MalformedRequest
    );
    assert_eq!(view.warnings, body.warnings);
    assert_eq!(view.warnings[0].text.of(view.names), Ok("Tür"));
    assert_eq!(view.message, "one line");
    assert!(
        TextSpan { offset: 6, len: 1 }
            .of(view.names)
            .is_err(),
        "cuts a character"
    );
}

#[test]
fn long_text_is_cut_at_a_character() {
    let text = "ü".repeat(MAX_TEXT);
    let body = ResponseBody {
        message: &text,
        ..Default::default()
    };
    let mut header = ResponseHeader::default();
    let bytes = body.lay_out(&mut header).unwrap();
    assert_eq!(header.message.count as usize, MAX_TEXT);
    let mut payload = vec![0; bytes];
    body.write(&header, &mut payload);
    assert!(std::str::from_utf8(&payload).is_ok());
}

#[test]
fn control_messages_keep_their_limit() {
    let message = ControlRequest::LoadRobot {
        label: "panda".into(),
        source: RobotSource {
            urdf: "/models/panda.urdf".into(),
            ..Default::default()
        },
        replace: false,
        files: None,
    };
    let bytes = control::encode(&message).unwrap();
    assert_eq!(control::decode::<ControlRequest>(&bytes).unwrap(), message);
    let longer = [bytes.as_slice(), &[0]].concat();
    assert!(control::decode::<ControlRequest>(&longer).is_err());
    let huge = ControlRequest::Describe {
        label: "x".repeat(CONTROL_MAX),
    };
    assert!(matches!(
        control::encode(&huge),
        Err(control::ControlError::TooLarge)
    ));
    // A piece of the largest size fits; one that claims 2^60 bytes is not allocated.
    let file = FileId {
        sha256: [200; 32],
        bytes: GIVE_MAX as u64,
    };
    let piece = |bytes| ControlRequest::Give {
        file,
        offset: 0,
        bytes,
    };
    let message = piece(vec![7; GIVE_MAX]);
    let bytes = control::encode(&message).unwrap();
    assert_eq!(control::decode::<ControlRequest>(&bytes).unwrap(), message);
    let mut claim = control::encode(&piece(Vec::new())).unwrap();
    *claim.last_mut().unwrap() = 253;
    claim.extend([0, 0, 0, 0, 0, 0, 0, 16]);
    assert!(control::decode::<ControlRequest>(&claim).is_err());
    // Nor a list that claims as many entries.
    let claim = [4u8, 253, 0, 0, 0, 0, 0, 0, 0, 16];
    assert!(control::decode::<ControlReply>(&claim).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes_never_panic(
        header in prop::collection::vec(any::<u8>(), size_of::<ResponseHeader>()),
        payload in prop::collection::vec(any::<u8>(), 0..300),
        shift in 0usize..8,
    ) {
        let words = aligned(&payload);
        let bytes: &[u8] = bytemuck::cast_slice(&words);
        let bytes = &bytes[shift.min(bytes.len())..];
        let _ = RequestView::parse(bytemuck::pod_read_unaligned(&header[..200]), bytes);
        let _ = ResponseView::parse(bytemuck::pod_read_unaligned(&header), bytes);
        let _ = control::decode::<ControlRequest>(&payload);
        let _ = control::decode::<ControlReply>(&payload);
    }

    /// Headers that pass the first checks reach the sections.
    #[test]
    fn random_sections_never_panic(
        sections in prop::collection::vec((0u32..20, 0u32..4), 15),
        wild in prop::collection::vec(any::<u32>(), 4),
        use_wild in any::<bool>(),
        payload in prop::collection::vec(any::<u8>(), 0..300),
        size in (0u32..3, 0u32..3),
    ) {
        let words = aligned(&payload);
        let bytes = &bytemuck::cast_slice(&words)[..payload.len()];
        let s = |i: usize| Section { offset: sections[i].0 * 8, count: sections[i].1 };
        let last = if use_wild { Section { offset: wild[0], count: wild[1] } } else { s(4) };
        let request = RequestHeader {
            waypoints: size.0, variables: size.1, path: s(0), weights: s(1), fixed_waypoints: s(2),
            group_mask: s(3), held_values: last, constraints: s(5), timing: s(7), ..request()
        };
        if let Ok(view) = RequestView::parse(request, bytes) {
            prop_assert_eq!(view.path.len() as u32, size.0 * size.1);
        }
        let response = ResponseHeader {
            wire_version: 1, header_len: 400, code: 1, waypoints: size.0, variables: size.1,
            path: s(0), certificate: s(1), lowered_floors: s(2), holds: s(3),
            stages: s(8), pinched: s(9), refusal: last, certificate_head: s(5), names: s(6), message: s(7), warnings: s(10), turned_columns: s(11), keeps: s(12),
            constraints: s(13), constraint_claims: s(14), trajectory: TrajectoryPlaces {
                head: s(2), times: s(10), positions: s(0), velocities: s(3), limits: s(9), used: s(8), nearest: s(5), ..Default::default()
            }, ..Default::default()
        };
        if let Ok(view) = ResponseView::parse(response, bytes) {
            let _ = TextSpan { offset: wild[2], len: wild[3] }.of(view.names);
        }
    }
}
