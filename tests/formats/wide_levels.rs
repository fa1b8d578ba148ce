//! Index tables of 32 bits: where a level has more vertices than 16 bits can name.

use crate::independent_reader::Reader;
use crate::tiny_pack;
use crowd_pack::{AnimationLayout, Error, LevelRecord, LodRecord, Pack, PackContents};

/// The flag with so many vertices that nobody uses, all of which go with its last one.
fn wide_flag(vertex_count: u32) -> PackContents {
    let mut pack = tiny_pack::contents(AnimationLayout::Premultiplied3x4);
    let wide = vertex_count as usize;
    pack.manifest.characters.truncate(1);
    pack.characters.truncate(1);
    pack.characters[0].vertex_count = vertex_count;
    pack.vertices.truncate(4);
    pack.vertices.resize(wide, pack.vertices[3]);
    pack.collapse_map.truncate(4);
    pack.collapse_map.resize(wide, 2);
    pack.triangles.truncate(2);
    pack.triangles[1] = [1, vertex_count - 1, 2];
    pack.lods = vec![pack.lods[0]; wide];
    pack.lods.push(LodRecord { vertex_count, triangle_count: 2 });
    pack.clips.truncate(1);
    pack.animation.truncate(3);
    pack.materials.truncate(1);
    pack.track_values.clear();
    pack.level_sets.truncate(1);
    pack.levels.truncate(2);
    pack.refit_vertices.clear();
    pack.indices_16.truncate(3);
    let table = [0, 1, 2, 2, 1, vertex_count - 1];
    let index_bytes = LevelRecord::index_bytes_for(vertex_count);
    let index_offset = if index_bytes == 2 { 3 } else { 0 };
    pack.levels[1] = LevelRecord { vertex_count, index_offset, index_bytes, ..pack.levels[1] };
    if index_bytes == 2 {
        pack.indices_16.extend(table.map(|index| index as u16));
    } else {
        pack.indices_32.extend(table);
    }
    let named = &mut pack.manifest.characters[0];
    named.levels[1].vertex_count = vertex_count;
    named.measured[1].vertex_count = vertex_count;
    pack
}

#[test]
fn sixteen_bits_as_long_as_the_restart_index_stays_free() {
    for (vertex_count, wide) in [(65_534, 0), (65_535, 0), (65_536, 6), (70_000, 6)] {
        let pack = wide_flag(vertex_count);
        assert_eq!(pack.indices_32.len(), wide, "{vertex_count} vertices");
        let bytes = pack.to_bytes().unwrap();
        assert_eq!(Pack::from_bytes(&bytes).unwrap().contents(), &pack);
        let reader = Reader::new(&bytes);
        let table = &reader.level_tables(0)[1];
        assert_eq!(table.triangles, [[0, 1, 2], [2, 1, vertex_count as usize - 1]]);
    }
}

#[test]
fn a_wide_index_out_of_range_is_refused() {
    let mut pack = wide_flag(70_000);
    pack.indices_32[5] = 70_000;
    let error = pack.to_bytes().unwrap_err();
    assert!(matches!(&error, Error::Format { place, .. } if place.contains("level with table 1: indices")), "{error}");
    let mut pack = wide_flag(70_000);
    pack.levels[1].index_bytes = 2;
    assert!(pack.to_bytes().unwrap_err().to_string().contains("bytes of an index"));
}
