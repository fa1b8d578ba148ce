//! Performs a collapse and logs what goes with it.

use super::{Run, Scratch, Surface};
use crate::find_images::{Image, ImageFinder, Moved, SEARCHED_TRIANGLES};

impl Run<'_> {
    /// Moves the centre of the fan in `scratch` to `t` and logs the step.
    pub(super) fn collapse(&mut self, t: u32, scratch: &Scratch) {
        let Scratch { fan, on_edge: dying, moved, .. } = scratch;
        let u = fan.center;
        let move_cost = match self.known_costs[u as usize].iter().find(|k| k.0 == t) {
            Some(&(_, cost)) => cost,
            None => self.surface.quadrics.move_cost(u, t),
        };
        self.steps.costs.push(self.mean_cost(u, t, move_cost, dying));

        self.surface.gaps.follow(self.surface.topology, u, t);
        self.volumes.follow(fan, self.rules, t);
        let images = self.settle_images(t, moved);
        let topology = &mut *self.surface.topology;
        let moving: Vec<u32> = topology.around(u).filter(|i| !dying.contains(i)).collect();
        let mut touched: Vec<u32> = Vec::new();
        let mut thirds: Vec<u32> = Vec::new();
        for &i in dying {
            thirds.push(topology.third(i, u, t));
            for v in topology.triangles[i as usize] {
                self.references[v as usize] -= 1;
                touched.push(v);
            }
            topology.remove(i);
            self.surface.behind.remove(i);
            self.steps.removed.push(i);
        }
        while topology.alive.get(self.first_alive).is_some_and(|&alive| !alive) {
            self.first_alive += 1;
        }
        for &i in &moving {
            let corner = topology.corner_at(i, u);
            let variant = topology.triangles[i as usize][corner];
            let image = image_of(&images, variant);
            topology.triangles[i as usize][corner] = image;
            self.references[variant as usize] -= 1;
            self.references[image as usize] += 1;
        }
        topology.move_triangles(u, t, &moving);
        self.drop_unreferenced(&images, touched);
        self.steps.dropped_ends.push(self.steps.dropped.len() as u32);
        self.steps.removed_ends.push(self.steps.removed.len() as u32);

        self.surface.quadrics.merge(u, t, move_cost);
        self.lost[t as usize] += self.lost[u as usize];
        thirds.sort_unstable();
        thirds.dedup();
        for c in thirds {
            // A place without triangles left: what it stood for goes on at the target.
            if self.surface.topology.valence(c) == 0 {
                let move_cost = self.surface.quadrics.move_cost(c, t);
                self.surface.quadrics.merge(c, t, move_cost);
                self.lost[t as usize] += self.lost[c as usize];
                self.volumes.inherit(c, t);
                self.stamps[c as usize] += 1;
            }
        }
        self.known_costs[t as usize].clear();
        self.known_costs[u as usize] = Vec::new();
        self.stamps[u as usize] += 1;
        self.grown[t as usize] += 1;
    }

    /// Makes the stand-ins that a collapse needs and merges the attributes. Returns each variant with its image.
    fn settle_images(&mut self, t: u32, moved: &[Moved]) -> Vec<(u32, u32)> {
        let Surface { split, normals, attributes, .. } = &mut self.surface;
        let mut images = Vec::with_capacity(moved.len());
        let mut made: Vec<(Image, u32)> = Vec::new();
        for m in moved {
            let image = match m.image {
                Image::Variant(image) => image,
                Image::StandIn { wedge, uv_of, normal_of } => match made.iter().find(|&&(image, _)| image == m.image) {
                    Some(&(_, image)) => image,
                    None => {
                        let image = split.add_stand_in(t, wedge, uv_of, normal_of);
                        normals.push(normals[normal_of as usize]);
                        attributes.add_stand_in(t, uv_of, normal_of);
                        self.references.push(0);
                        made.push((m.image, image));
                        image
                    }
                },
            };
            attributes.merge(m.variant, image);
            images.push((m.variant, image));
        }
        images
    }

    /// Logs the variants that no triangle uses any more: those of the position that moved, and those on its old
    /// neighbours whose last triangle died.
    fn drop_unreferenced(&mut self, images: &[(u32, u32)], mut touched: Vec<u32>) {
        let Surface { split, normals, topology, attributes, .. } = &self.surface;
        let finder = ImageFinder { split, topology, attributes, normals, stand_ins: true };
        // Images that only dying triangles used, or that were made for them alone.
        touched.extend(images.iter().map(|&(_, image)| image));
        touched.sort_unstable();
        touched.dedup();
        let start = self.steps.dropped.len();
        for v in touched {
            let moved = images.iter().any(|&(from, _)| from == v);
            if self.references[v as usize] > 0 || moved {
                continue;
            }
            let p = split.position_of(v);
            let wedge = split.variant_wedge[v as usize];
            let variant = |i: u32| topology.triangles[i as usize][topology.corner_at(i, p)];
            let around = || topology.around(p).take(SEARCHED_TRIANGLES).map(variant);
            let same_wedge = around().filter(|&w| split.variant_wedge[w as usize] == wedge);
            let stand_in = finder.closest(v, same_wedge).or_else(|| finder.closest(v, around()));
            self.steps.dropped.push((v, stand_in.unwrap_or(u32::MAX)));
        }
        for &(from, to) in images {
            // The image may itself have been used by dying triangles only.
            let to = self.steps.dropped[start..].iter().find(|d| d.0 == to).map_or(to, |d| d.1);
            self.steps.dropped.push((from, to));
        }
        // Where a place has lost its last triangle, its variants go where the moved ones went, or, with the whole part, to any survivor.
        let images_of_moved = images.iter().map(|&(from, _)| from).collect::<Vec<_>>();
        let settled = self.steps.dropped[start..].iter().map(|d| d.1).find(|&to| to != u32::MAX);
        let refuge = settled.unwrap_or_else(|| self.any_survivor());
        for dropped in &mut self.steps.dropped[start..] {
            if dropped.1 == u32::MAX || images_of_moved.contains(&dropped.1) {
                dropped.1 = refuge;
            }
        }
        self.steps.dropped[start..].sort_unstable();
    }

    /// A variant that some triangle uses: a vanished part's vertices have to be something.
    fn any_survivor(&self) -> u32 {
        let topology = &self.surface.topology;
        assert!(self.first_alive < topology.alive.len(), "the last part never vanishes");
        topology.triangles[self.first_alive][0]
    }
}

fn image_of(images: &[(u32, u32)], variant: u32) -> u32 {
    images.iter().find(|&&(from, _)| from == variant).expect("every variant of the position was mapped").1
}
