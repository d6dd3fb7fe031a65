//! Invalid input is refused with its name, and changes nothing.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use sinew_core::{
    Error, Musculature, Regional, RestMesh, Skeleton, Skin, SkinOptions, Tissue, TissueDescription,
    TissueKind,
};

use super::rig::{PLAIN, columns, no_tension};

fn description() -> TissueDescription {
    TissueDescription {
        name: "biceps".into(),
        kind: TissueKind::Muscle,
        origin_bone: 0,
        insertion_bone: 1,
        centre: [0.0; 3],
        rotation: [1.0, 0.0, 0.0, 0.0],
        semi_axes: [0.01, 0.02, 0.1],
        origin_tendon_m: 0.0,
        insertion_tendon_m: 0.0,
        volume_keeping: 1.0,
        via_points: vec![],
        wraps: vec![],
    }
}

#[test]
fn tissues() {
    type Spoil = fn(&mut TissueDescription);
    let spoils: [(Spoil, &str); 12] = [
        (|tissue| tissue.origin_bone = -1, "origin bone"),
        (|tissue| tissue.insertion_bone = -3, "insertion bone"),
        (|tissue| tissue.centre[1] = f64::NAN, "centre"),
        (|tissue| tissue.semi_axes[0] = 0.0, "semi-axis"),
        (|tissue| tissue.semi_axes[2] = -1.0, "semi-axis"),
        (|tissue| tissue.semi_axes[2] = f64::INFINITY, "semi-axis"),
        (|tissue| tissue.rotation = [0.0; 4], "rotation"),
        (|tissue| tissue.origin_tendon_m = -0.1, "origin tendon"),
        (|tissue| tissue.insertion_tendon_m = f64::NAN, "insertion tendon"),
        (|tissue| tissue.volume_keeping = 1.6, "volume keeping"),
        (|tissue| tissue.volume_keeping = -0.1, "volume keeping"),
        (|tissue| tissue.kind = TissueKind::Bone, "rigid"),
    ];
    assert!(Tissue::new(description()).is_ok());
    for (spoil, named) in spoils {
        let mut spoilt = description();
        spoil(&mut spoilt);
        let message = Tissue::new(spoilt).unwrap_err().to_string();
        assert!(message.contains("biceps") && message.contains(named), "{message}");
    }
}

#[test]
fn skeletons() {
    let identity = columns(DAffine3::IDENTITY);
    let new = |parents: &[i32], rest: &[[f32; 16]]| {
        Skeleton::new(vec!["a".into(), "b".into()], parents, rest).map(|skeleton| skeleton.len())
    };
    assert_eq!(new(&[-1, 0], &[identity; 2]), Ok(2));
    assert!(matches!(new(&[1, 0], &[identity; 2]), Err(Error::Cycle { .. })));
    assert!(matches!(new(&[0, -1], &[identity; 2]), Err(Error::Cycle { .. })));
    assert!(matches!(new(&[-1, 2], &[identity; 2]), Err(Error::Index { .. })));
    assert!(matches!(new(&[-2, 0], &[identity; 2]), Err(Error::Index { .. })));
    assert!(matches!(new(&[-1], &[identity; 2]), Err(Error::Length { .. })));
    let flat = columns(DAffine3::from_scale(DVec3::new(1.0, 1.0, 0.0)));
    assert!(matches!(
        new(&[-1, 0], &[identity, flat]),
        Err(Error::Singular { .. })
    ));
    let mut row_major = identity;
    row_major[3] = 0.5;
    assert!(matches!(
        new(&[-1, 0], &[identity, row_major]),
        Err(Error::Projective { .. })
    ));
    let twice = Skeleton::new(vec!["a".into(), "a".into()], &[-1, 0], &[identity; 2]);
    assert!(matches!(twice, Err(Error::Duplicate { kind: "bone", .. })));
    let nameless = Skeleton::new(vec!["a".into(), String::new()], &[-1, 0], &[identity; 2]);
    assert!(matches!(nameless, Err(Error::Nameless { .. })));
}

#[test]
fn musculatures() {
    let twice = vec![
        Tissue::new(description()).unwrap(),
        Tissue::new(description()).unwrap(),
    ];
    assert!(matches!(
        Musculature::new(PLAIN.skeleton(), twice),
        Err(Error::Duplicate { kind: "tissue", .. })
    ));
    let far = Tissue::new(TissueDescription {
        insertion_bone: 3,
        ..description()
    })
    .unwrap();
    assert!(matches!(
        Musculature::new(PLAIN.skeleton(), vec![far]),
        Err(Error::UnknownBone { .. })
    ));
}

#[test]
fn skins() {
    let identity = columns(DAffine3::IDENTITY);
    let good = RestMesh {
        points: &[[0.0; 3], [0.1; 3]],
        edges: &[[0, 1]],
        mesh_to_armature: &identity,
        weight_offsets: &[0, 1, 2],
        weight_bones: &[0, 1],
        weights: &[1.0, 1.0],
    };
    let new =
        |mesh: &RestMesh, options: &SkinOptions| Skin::new(PLAIN.musculature(), mesh, options).map(|_| ());
    let plain = SkinOptions::default();
    assert_eq!(new(&good, &plain), Ok(()));
    assert_eq!(
        new(
            &RestMesh {
                points: &[],
                weight_offsets: &[0],
                ..good
            },
            &plain
        ),
        Err(Error::NoVertices)
    );
    let bad: [RestMesh; 8] = [
        RestMesh {
            edges: &[[0, 2]],
            ..good
        },
        RestMesh {
            edges: &[[-1, 0]],
            ..good
        },
        RestMesh {
            weight_offsets: &[0, 2],
            ..good
        },
        RestMesh {
            weight_offsets: &[0, 3, 2],
            ..good
        },
        RestMesh {
            weight_offsets: &[1, 1, 2],
            ..good
        },
        RestMesh {
            weight_offsets: &[0, 1, 1],
            ..good
        },
        RestMesh {
            weight_bones: &[0, 3],
            ..good
        },
        RestMesh {
            weights: &[0.5, -0.5],
            ..good
        },
    ];
    let refuses_a_list = |mesh: &RestMesh| {
        matches!(
            new(mesh, &plain),
            Err(Error::Length { .. } | Error::Index { .. } | Error::Offsets { .. } | Error::Weight { .. })
        )
    };
    assert!(bad.iter().all(refuses_a_list));
    let flat = columns(DAffine3::from_scale(DVec3::new(0.0, 1.0, 1.0)));
    assert!(matches!(
        new(
            &RestMesh {
                mesh_to_armature: &flat,
                ..good
            },
            &plain
        ),
        Err(Error::Singular { .. })
    ));
    for options in [
        SkinOptions {
            falloff_m: -0.1,
            ..plain
        },
        SkinOptions {
            softness_m: 0.0,
            ..plain
        },
        SkinOptions {
            muscle_influence: Regional::of_body(f64::NAN),
            ..plain
        },
    ] {
        assert!(matches!(new(&good, &options), Err(Error::Value { .. })));
    }
    let bare = Arc::new(Musculature::new(PLAIN.skeleton(), vec![]).unwrap());
    assert!(matches!(Skin::new(bare, &good, &plain), Err(Error::NoTissues)));
}

#[test]
fn frames_that_fail_write_nothing() {
    let skin = PLAIN.skin(&SkinOptions::default());
    let before = vec![[7.0; 3]; skin.len()];
    let mut out = before.clone();
    let pose = PLAIN.rest_pose();
    let mut projective = pose.clone();
    projective[1][3] = 1.0;
    let mut tense = no_tension();
    tense[2] = 1.5;
    assert!(skin.correct(&pose[1..], &no_tension(), &mut out).is_err());
    assert!(skin.correct(&projective, &no_tension(), &mut out).is_err());
    assert!(
        skin.correct(&pose, &tense, &mut out)
            .is_err_and(|error| error.to_string().contains("far"))
    );
    assert!(skin.correct(&pose, &no_tension()[1..], &mut out).is_err());
    assert!(skin.deform(&pose, &no_tension(), &mut out[1..]).is_err());
    assert_eq!(out, before);
    assert!(skin.deform(&pose, &no_tension(), &mut out).is_ok());
}
