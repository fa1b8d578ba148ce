//! What is written comes back, byte for byte.

use crate::random_pack;
use crowd_pack::{Pack, PackContents};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn contents_come_back(seed: u64) {
        let contents = random_pack::contents(seed);
        let bytes = contents.to_bytes().unwrap();
        prop_assert_eq!(&bytes, &contents.clone().to_bytes().unwrap());
        let pack = Pack::from_bytes(&bytes).unwrap();
        prop_assert_eq!(pack.contents(), &contents);
        prop_assert_eq!(pack.contents().to_bytes().unwrap(), bytes);
    }
}

#[test]
fn an_empty_pack_is_a_pack() {
    let bytes = PackContents::default().to_bytes().unwrap();
    assert_eq!(Pack::from_bytes(&bytes).unwrap().contents(), &PackContents::default());
}

#[test]
fn an_image_is_stored_once() {
    let mut pack = PackContents::default();
    let indices = [&b"one"[..], b"two", b"one"].map(|image| pack.add_image(image, 1, 1, 0));
    assert_eq!(indices, [0, 1, 0]);
    assert_eq!((pack.images[1].byte_offset, pack.image_bytes.len()), (64, 67));
}
