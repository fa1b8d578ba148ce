//! Every file of the assets folder: what it must give, or the words with which it must be refused.

use crowd_source::{ImageEncoding, Limits, load_character};

use crate::assets::{files_below, folder, load, try_load};
use crate::invariants::broken_promise;

/// Files, triangles as drawn (the folder's README counts them), clips, images used as base colour.
const CHARACTERS: &[(&str, usize, usize, usize)] = &[
    ("khronos-fox/Fox.gltf", 576, 3, 1),
    ("khronos-fox/Fox.glb", 576, 3, 1),
    ("khronos-cesium-man/CesiumMan.glb", 4672, 1, 1),
    ("khronos-rigged/RiggedFigure.glb", 256, 1, 0),
    ("khronos-rigged/RiggedSimple.glb", 188, 1, 0),
    ("kaykit-adventurers/Barbarian.glb", 6543, 76, 1),
    ("kaykit-adventurers/Knight.glb", 6952, 76, 1),
    ("kaykit-adventurers/Mage.glb", 5683, 76, 1),
    ("kaykit-adventurers/Rogue.glb", 6377, 76, 1),
    ("kaykit-adventurers/Rogue_Hooded.glb", 6035, 76, 1),
    ("kaykit-adventurers/props/sword_1handed.gltf", 300, 0, 1),
    ("kaykit-adventurers/props/shield_round.gltf", 284, 0, 1),
    ("kaykit-skeleton-minion/skeleton_minion.glb", 5288, 4, 1),
    ("quaternius-ultimate-characters/Knight_Male.gltf", 2992, 17, 0),
    ("quaternius-ultimate-characters/Wizard.gltf", 6482, 17, 0),
    ("quaternius-modular-witch/Witch.gltf", 6872, 24, 0),
    ("quaternius-modular-men/Suit.glb", 6634, 0, 0),
    ("quaternius-modular-men/Swat.glb", 7753, 0, 0),
    ("quaternius-modular-men/Farmer.glb", 5476, 0, 0),
    ("quaternius-animals/Horse.glb", 2182, 13, 0),
    ("quaternius-animals/Wolf.glb", 1962, 12, 0),
    ("quaternius-mech-leela/Leela.glb", 2368, 18, 1),
    ("gdquest-gdbot/gdbot.glb", 9828, 7, 1),
    ("quaternius-robot/robot.glb", 3238, 14, 0),
    ("valid-avatars/Black_M_1_Casual.glb", 58724, 0, 1),
    ("valid-avatars/Black_M_1_Busi.glb", 58724, 0, 1),
    ("makehuman-man/man_casual.gltf", 30578, 6, 5),
    ("makehuman-man/man_parts.gltf", 65542, 2, 6),
    ("makehuman-man/man_casual_12influences.gltf", 30578, 1, 5),
    ("makehuman-man/man_casual.obj", 30578, 0, 5),
    ("obj-spot/cow.obj", 5856, 0, 1),
];

/// Files of nasty/valid that are out of scope, and the words that say so.
const OUT_OF_SCOPE: &[(&str, &str)] = &[
    ("MorphPrimitivesTest_draco.glb", "the extension KHR_draco_mesh_compression is not supported; decompress"),
    ("cesium_man_draco.glb", "the extension KHR_draco_mesh_compression is not supported; decompress"),
    ("kenney_zombie_draco.gltf", "the extension KHR_draco_mesh_compression is not supported; decompress"),
    ("Mesh_PrimitiveMode_00.gltf", "1 primitives are points or lines"),
];

/// Files of nasty/invalid and the words that must come back.
const INVALID: &[(&str, &str)] = &[
    ("Compatibility_04.gltf", "asset: glTF minVersion \"2.1\" is not supported"),
    ("Compatibility_05.gltf", "the extension FAKE_materials_quantumRendering is not supported"),
    ("IndexOutOfRange.gltf", "primitive 0: indices: index 0 is vertex 255, the primitive has 24 vertices"),
    ("MissingBin.gltf", "BoxTextured0.bin"),
    ("RecursiveNodes.gltf", "its ancestors form a loop"),
    ("badArray.gltf", "expected a sequence at line"),
    ("badUint.gltf", "integer `-1`"),
    ("empty.gltf", "empty, expected glTF"),
    ("fox_bad_length.glb", "says 162852 bytes, the file has 4000"),
    ("fox_truncated.glb", "says 162852 bytes, the file has 81426"),
    ("invalid-buffer-index.gltf", "no triangles"),
    ("invalid-primitive-indices.gltf", "no triangles"),
    ("malformed.obj", "line 23: face corner `12`: vertex 12, the file has 8"),
];

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn every_character_loads_with_the_counts_of_the_readme() {
    for &(name, triangles, clips, images) in CHARACTERS {
        let character = load(name);
        assert_eq!(broken_promise(&character), None, "{name}");
        let dropped = character.warnings.iter().filter(|w| w.code == "degenerate-triangles-dropped");
        let drawn = character.mesh.triangles.len() + dropped.map(|w| w.count as usize).sum::<usize>();
        let found = (drawn, character.clips.len(), character.images.len());
        assert_eq!(found, (triangles, clips, images), "{name}: triangles, clips, images");
    }
}

/// The list above is the folder's: a file that comes in must be listed.
#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn no_character_of_the_folder_is_left_out() {
    let listed = CHARACTERS.iter().map(|c| folder().join(c.0));
    let mut listed: Vec<_> = listed.collect();
    listed.sort();
    let nasty = folder().join("nasty");
    let found: Vec<_> = files_below("").into_iter().filter(|f| !f.starts_with(&nasty)).collect();
    assert_eq!(found, listed);
}

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn nasty_but_valid_files_load_or_name_what_is_out_of_scope() {
    let mut refused = 0;
    for path in files_below("nasty/valid") {
        let file = path.file_name().expect("a name").to_string_lossy().into_owned();
        let out_of_scope = OUT_OF_SCOPE.iter().find(|(name, _)| *name == file);
        match (load_character(&path, &Limits::default()), out_of_scope) {
            (Ok(character), None) => assert_eq!(broken_promise(&character), None, "{file}"),
            (Err(error), Some((_, words))) => {
                assert!(error.to_string().contains(words), "{file}: {error}");
                refused += 1;
            }
            (Ok(_), Some(_)) => panic!("{file} was to be refused"),
            (Err(error), None) => panic!("{file} was to load: {error}"),
        }
    }
    assert_eq!(refused, OUT_OF_SCOPE.len());
}

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn invalid_files_are_refused_with_their_reason() {
    let files = files_below("nasty/invalid");
    assert_eq!(files.len(), INVALID.len());
    for path in files {
        let file = path.file_name().expect("a name").to_string_lossy().into_owned();
        let (_, words) = INVALID.iter().find(|(name, _)| *name == file).expect("listed");
        let error = load_character(&path, &Limits::default()).expect_err(&file).to_string();
        assert!(error.contains(words), "{file}: {error}");
    }
}

/// Triangles face where their normals point: windings, mirrored nodes and inverse transposes are right.
#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn triangles_face_where_their_normals_point() {
    for &(name, ..) in CHARACTERS {
        let mesh = load(name).mesh;
        let at = |v: u32| glam::Vec3::from_array(mesh.positions[v as usize]).as_dvec3();
        let normal = |v: u32| glam::Vec3::from_array(mesh.normals[v as usize]).as_dvec3();
        let (mut along, mut all) = (0.0, 0.0);
        for [a, b, c] in mesh.triangles.iter().copied() {
            let area = (at(b) - at(a)).cross(at(c) - at(a));
            all += area.length();
            if area.dot(normal(a) + normal(b) + normal(c)) > 0.0 {
                along += area.length();
            }
        }
        assert!(along > 0.97 * all, "{name}: {:.1} % of the surface faces along its normals", along / all * 100.0);
    }
}

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn rigid_weapons_and_skinned_bodies_are_told_apart() {
    for (name, rigid) in [("Barbarian", 7), ("Knight", 9), ("Mage", 6), ("Rogue", 6), ("Rogue_Hooded", 6)] {
        let character = load(&format!("kaykit-adventurers/{name}.glb"));
        assert_eq!(character.mesh.parts.iter().filter(|p| p.rigid).count(), rigid, "{name}");
    }
}

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn what_is_dropped_is_said() {
    let warnings = |name: &str, code: &str| -> Vec<(u64, String)> {
        let found = load(name).warnings.into_iter().filter(|w| w.code == code);
        found.map(|w| (w.count, w.message)).collect()
    };
    let dropped = warnings("makehuman-man/man_casual_12influences.gltf", "weights-dropped");
    assert!(
        dropped.iter().map(|d| d.0).sum::<u64>() > 4000 && dropped.iter().any(|d| d.1.contains("0.168")),
        "{dropped:?}"
    );
    assert!(warnings("makehuman-man/man_casual.gltf", "weights-dropped").is_empty());
    let morphs = warnings("valid-avatars/Black_M_1_Casual.glb", "morph-targets-ignored");
    assert_eq!(morphs.iter().map(|m| m.0).collect::<Vec<_>>(), [65, 31]);
    assert_eq!(warnings("gdquest-gdbot/gdbot.glb", "alpha-blend-as-mask").len(), 1);
    assert!(load("khronos-fox/Fox.glb").warnings.is_empty());
}

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn surfaces_come_through() {
    let leela = load("quaternius-mech-leela/Leela.glb");
    assert!(leela.materials[0].unlit);
    assert_eq!((leela.images[0].width, leela.images[0].encoding), (2048, ImageEncoding::Png));
    assert_eq!(load("valid-avatars/Black_M_1_Casual.glb").images[0].encoding, ImageEncoding::WebP);
    assert_eq!(load("khronos-cesium-man/CesiumMan.glb").images[0].encoding, ImageEncoding::Jpeg);
    let man = load("makehuman-man/man_casual.gltf");
    assert!(man.materials.iter().any(|m| m.alpha_cutoff.is_some()));
    assert!(load("khronos-fox/Fox.glb").materials[0].flat_normals);
    let suit = load("quaternius-modular-men/Suit.glb");
    assert!(suit.materials.iter().any(|m| m.base_color != [1.0; 4]));
}

/// The same character as glTF and as OBJ: same place, same surface.
#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn the_man_is_the_same_as_gltf_and_as_obj() {
    let (gltf, obj) = (load("makehuman-man/man_casual.gltf"), load("makehuman-man/man_casual.obj"));
    assert_eq!(gltf.mesh.positions.len(), obj.mesh.positions.len());
    let key = |c: &crowd_source::RawCharacter| {
        let mut all: Vec<[i64; 5]> = (0..c.mesh.positions.len())
            .map(|v| {
                let ([x, y, z], [s, t]) = (c.mesh.positions[v], c.mesh.uvs[v]);
                [x, y, z, s, t].map(|n| (f64::from(n) * 500.0).round() as i64)
            })
            .collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    let (gltf, obj) = (key(&gltf), key(&obj));
    let common = gltf.iter().filter(|v| obj.binary_search(v).is_ok()).count();
    assert!(common * 100 > gltf.len() * 97, "{common} of {} vertices agree to 2 mm and in UV", gltf.len());
}

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn loading_twice_gives_the_same() {
    for name in ["kaykit-adventurers/Knight.glb", "valid-avatars/Black_M_1_Busi.glb", "makehuman-man/man_casual.obj"] {
        assert_eq!(load(name), load(name), "{name}");
    }
}

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn blanks_and_folders_in_names_are_found() {
    for name in ["CubeImageUriSpaces.gltf", "CubeImageUriMultipleSpaces.gltf"] {
        assert_eq!(load(&format!("nasty/valid/uri_spaces/{name}")).images.len(), 1);
    }
    assert_eq!(load("nasty/valid/kenney_platformer/character.glb").images.len(), 1);
    assert!(try_load("nasty/valid/kenney_platformer/gone.glb").is_err());
}
