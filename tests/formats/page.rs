//! The tables of `docs/FORMAT.md` say what the records are: name, place and size of every field, and the limits.

use crowd_pack::{
    CharacterRecord, ClipRecord, ImageRecord, ImpostorRecord, LevelRecord, LevelSetRecord, LodRecord, MaterialRecord,
    VertexRecord, limits,
};
use std::mem::offset_of;

const PAGE: &str = include_str!("../../docs/FORMAT.md");

/// Rows of the table under a heading: byte, bytes of the type, name.
fn rows(heading: &str) -> Vec<(usize, usize, String)> {
    let start = PAGE.find(heading).unwrap_or_else(|| panic!("no heading {heading}"));
    let lines = PAGE[start..].lines().skip_while(|line| !line.starts_with("| byte"));
    lines.take_while(|line| line.starts_with('|')).skip(2).map(row).collect()
}

fn row(line: &str) -> (usize, usize, String) {
    let cells: Vec<&str> = line.split('|').map(str::trim).collect();
    let (count, scalar) = cells[2].split_once(" x ").unwrap_or(("1", cells[2]));
    let bytes = match scalar {
        "u64" => 8,
        "u32" | "f32" => 4,
        other => panic!("{line}: type {other}"),
    };
    (cells[1].parse().unwrap(), count.parse::<usize>().unwrap() * bytes, cells[3].to_owned())
}

/// The page's table against the struct: same fields at the same places, nothing between, nothing behind.
fn check(heading: &str, size: usize, fields: &[(&str, usize)]) {
    let rows = rows(heading);
    let on_page: Vec<(&str, usize)> = rows.iter().map(|(byte, _, name)| (name.as_str(), *byte)).collect();
    assert_eq!(on_page, fields, "{heading}");
    let ends = rows.iter().map(|(byte, bytes, _)| byte + bytes);
    let starts = rows.iter().skip(1).map(|(byte, ..)| *byte).chain([size]);
    assert!(ends.eq(starts), "{heading}: a gap or an overlap");
    assert!(heading.ends_with(&format!(", {size} bytes")));
}

macro_rules! check_record {
    ($record:ident, $heading:literal, $($field:ident)+) => {
        check($heading, size_of::<$record>(), &[$((stringify!($field), offset_of!($record, $field))),+]);
    };
}

#[test]
fn records_are_where_the_page_says() {
    check_record!(CharacterRecord, "### CharacterRecord, 112 bytes", vertex_offset vertex_count triangle_offset triangle_count
        lod_offset min_vertex_count min_triangle_count joint_count clip_offset clip_count material_offset material_count sphere
        box_min height_m box_max inverse_bind_offset joint_storage storage_error_m reserved);
    check_record!(VertexRecord, "### VertexRecord, 48 bytes", position normal_oct uv color material_class joints weights);
    check_record!(LodRecord, "### LodRecord, 8 bytes", vertex_count triangle_count);
    check_record!(ClipRecord, "### ClipRecord, 48 bytes", texel_offset frame_count duration_s ground_speed_m_s sphere
        root_displacement_m loop_gap_m);
    check_record!(MaterialRecord, "### MaterialRecord, 32 bytes", base_color image flags alpha_cutoff reserved);
    check_record!(LevelSetRecord, "### LevelSetRecord, 16 bytes", level_offset quantized_count discrete_count
        refit_vertex_offset);
    check_record!(LevelRecord, "### LevelRecord, 24 bytes", vertex_count triangle_count index_offset index_bytes
        refit_vertex_offset bound_m);
    check_record!(ImpostorRecord, "### ImpostorRecord, 48 bytes", tile_px azimuth_count elevation_count pose_count clip_count reserved
        color_byte_offset normal_byte_offset color_byte_count normal_byte_count);
    check_record!(ImageRecord, "### ImageRecord, 32 bytes", byte_offset byte_count width height encoding reserved);
}

#[test]
#[should_panic(expected = "LodRecord")]
fn a_moved_field_would_be_noticed() {
    check("### LodRecord, 8 bytes", 8, &[("triangle_count", 0), ("vertex_count", 4)]);
}

#[test]
fn limits_are_the_pages() {
    assert!(limits::PACK_BYTES == 8 << 30 && PAGE.contains("8 GiB a file"));
    assert!(limits::MANIFEST_BYTES == 256 << 20 && PAGE.contains("256 MiB of manifest"));
    assert!(limits::CHARACTERS == 4_096 && PAGE.contains("4,096 characters"));
    assert!(limits::IMAGES == 65_536 && PAGE.contains("65,536 images"));
    assert!(limits::VERTICES_PER_CHARACTER == 1 << 22 && PAGE.contains("2^22 vertices"));
    assert!(limits::TRIANGLES_PER_CHARACTER == 1 << 24 && PAGE.contains("2^24 triangles"));
    assert!(limits::JOINTS_PER_CHARACTER == 4_096 && PAGE.contains("4,096 joints"));
    assert!(limits::CLIPS_PER_CHARACTER == 65_536 && PAGE.contains("65,536 clips"));
    assert!(limits::MATERIALS_PER_CHARACTER == 65_535 && PAGE.contains("65,535 materials"));
    assert!(limits::QUANTIZED_LEVELS == 64 && PAGE.contains("64 quantised levels"));
    assert!(limits::DISCRETE_LEVELS == 32 && PAGE.contains("32 discrete levels"));
    assert!(limits::IMPOSTOR_TILE_PX == 128 && PAGE.contains("power of two from 8 to 128"));
    assert!(limits::IMPOSTOR_DIRECTIONS == 64 && PAGE.contains("1 to 64"));
    assert!(limits::IMPOSTOR_TEXELS == 1 << 26 && PAGE.contains("2^26 texels of impostors"));
    assert!(limits::IMAGE_SIDE_PX == 32_768 && PAGE.contains("pixels, 1 to 32768"));
}
