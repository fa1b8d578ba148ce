use super::*;
use proptest::prelude::*;

const CROSSING: &[u8] = include_bytes!("../../../../fixtures/scenes/crossing.sqlite");

fn count(bytes: &[u8], name: &str) -> crate::Result<usize> {
    let database = Database::new(bytes)?;
    let tables = Table::all(&database)?;
    let mut count = 0;
    Table::named(&tables, name)?.scan(&database, &mut |_| {
        count += 1;
        Ok(())
    })?;
    Ok(count)
}

#[test]
fn tables_of_several_pages_are_read_in_order() {
    let database = Database::new(CROSSING).expect("a database");
    let tables = Table::all(&database).expect("a schema");
    let names: Vec<&str> = tables.iter().map(|table| table.name.as_str()).collect();
    assert_eq!(names, ["trajectory_data", "metadata", "geometry", "frame_data"]);
    let people = Table::named(&tables, "trajectory_data").expect("listed");
    let (frame, x) = (people.column("frame").expect("there"), people.column("pos_x").expect("there"));
    let (mut rows, mut last) = (0, 0);
    people
        .scan(&database, &mut |row| {
            let frame = row.value(frame).as_i64().expect("whole");
            assert!(frame >= last && row.value(x).as_f64().is_some());
            (rows, last) = (rows + 1, frame);
            Ok(())
        })
        .expect("whole");
    assert_eq!((rows, last), (613, 70));
    assert_eq!(people.find("colour"), None);
}

#[test]
fn a_long_text_is_joined_from_its_pages() {
    let database = Database::new(CROSSING).expect("a database");
    let tables = Table::all(&database).expect("a schema");
    let table = Table::named(&tables, "geometry").expect("listed");
    let mut texts = Vec::new();
    table
        .scan(&database, &mut |row| {
            texts.push(row.value(1).as_text().expect("text").to_owned());
            Ok(())
        })
        .expect("whole");
    assert_eq!(texts.len(), 1);
    assert!(texts[0].len() > 1000 && texts[0].starts_with("POLYGON ((0 10") && texts[0].ends_with("))"));
}

#[test]
fn refusals_say_what_was_found() {
    for (bytes, expected) in [
        (&b"SQLite format 3\0"[..], "without SQLite's heading"),
        (b"", "0 bytes"),
        (&CROSSING[..3000], "a link to page"),
    ] {
        let message = count(bytes, "trajectory_data").expect_err(expected).to_string();
        assert!(message.contains(expected), "{message}");
    }
    let message = count(CROSSING, "people").expect_err("no such table").to_string();
    assert!(
        message.contains("found the tables trajectory_data, metadata") && message.contains("JuPedSim"),
        "{message}"
    );
    let mut wide = CROSSING.to_vec();
    wide[59] = 2;
    assert!(count(&wide, "metadata").expect_err("UTF-16").to_string().contains("text encoding 2"));
}

#[test]
fn a_tree_that_bites_its_tail_ends() {
    // Every interior page leads back to itself.
    let mut bytes = CROSSING.to_vec();
    for (index, page) in bytes.chunks_exact_mut(1024).enumerate() {
        if page[0] == 5 {
            page[8..12].copy_from_slice(&(index as u32 + 1).to_be_bytes());
        }
    }
    let message = count(&bytes, "trajectory_data").expect_err("a circle").to_string();
    assert!(message.contains("part of itself"), "{message}");
}

#[test]
fn rows_that_share_their_bytes_are_refused() {
    // Every pointer of a leaf shows the geometry's one long row, over and over.
    let mut bytes = CROSSING.to_vec();
    for page in bytes.chunks_exact_mut(1024).filter(|page| page[0] == 13) {
        let count = u16::from_be_bytes([page[3], page[4]]);
        if count == 1 {
            page[3..5].copy_from_slice(&300_u16.to_be_bytes());
            let first = [page[8], page[9]];
            for pointer in page[8..608].chunks_exact_mut(2) {
                pointer.copy_from_slice(&first);
            }
        }
    }
    let message = count(&bytes, "geometry").expect_err("too many").to_string();
    assert!(message.contains("share their bytes"), "{message}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]
    #[test]
    fn any_damage_is_read_or_refused(changes in proptest::collection::vec((0..CROSSING.len(), any::<u8>()), 1..8), end in 0..=CROSSING.len()) {
        let mut bytes = CROSSING.to_vec();
        for (place, value) in changes {
            bytes[place] = value;
        }
        for bytes in [&bytes[..], &bytes[..end]] {
            for name in ["trajectory_data", "geometry"] {
                let _ = count(bytes, name);
            }
        }
        let _ = crate::Trajectories::read(&bytes, None);
    }
}
