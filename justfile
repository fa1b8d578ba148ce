# A menu. Every recipe is one line that the README, CONTRIBUTING, a doc page or .ci/run has too; nothing needs `just`.

# Bake the shipped cast and picture a crowd
crowd:
    cargo run --release --locked -p crowdbake -- bake fixtures/cast.toml -o out/cast.crowdpack && cargo run --release --locked -p crowdplay -- out/cast.crowdpack --headless --count 3000 --size 1600x900 --out out/crowd.png

# Show the crowd in a window
play:
    cargo run --release -p crowdplay -- out/cast.crowdpack --count 10000

# All tests, installing software Vulkan where it can
test:
    bash tests/run.sh

# What CI runs
ci:
    bash .ci/run

# Write fixtures/ again (the committed bytes must come out)
fixtures:
    cargo run --release -p crowd-fixtures -- fixtures

# Accept new golden checksums (say in the commit why they moved)
golden:
    UPDATE_GOLDEN=1 cargo test --release -p crowd-tests --test golden

# Write docs/benchmarks/bars.md again, after any of the pages beside it
bars:
    UPDATE_BARS=1 cargo test --release --locked -p crowd-tests --test house bars

# Write docs/benchmarks/levels.md again: our levels and other simplifiers' side by side (gltfpack where it is on PATH)
compare assets="../shared/assets":
    cargo run --release -p crowdbake -- compare {{assets}}/khronos-cesium-man/CesiumMan.glb {{assets}}/khronos-fox/Fox.glb {{assets}}/kaykit-adventurers/Knight.glb {{assets}}/kaykit-adventurers/Mage.glb {{assets}}/gdquest-gdbot/gdbot.glb {{assets}}/makehuman-man/man_casual.gltf fixtures/good/mara.glb fixtures/good/zebra.glb -o docs/benchmarks/levels.md

# Write docs/benchmarks/levels-more.md again: the same for eleven more characters, which few decisions looked at
compare-more assets="../shared/assets":
    cargo run --release -p crowdbake -- compare {{assets}}/kaykit-adventurers/Barbarian.glb {{assets}}/kaykit-adventurers/Rogue.glb {{assets}}/kaykit-adventurers/Rogue_Hooded.glb {{assets}}/kaykit-skeleton-minion/skeleton_minion.glb {{assets}}/quaternius-mech-leela/Leela.glb {{assets}}/quaternius-modular-witch/Witch.gltf {{assets}}/quaternius-robot/robot.glb {{assets}}/quaternius-ultimate-characters/Knight_Male.gltf {{assets}}/quaternius-ultimate-characters/Wizard.gltf {{assets}}/quaternius-animals/Horse.glb {{assets}}/quaternius-animals/Wolf.glb --ours wedge,refit -o docs/benchmarks/levels-more.md

# Write docs/benchmarks/levels-rest.md again: the same for the other fixtures and all that is left of the assets (a quarter of an hour)
compare-rest assets="../shared/assets":
    cargo run --release -p crowdbake -- compare fixtures/good/anselm.glb fixtures/good/noor.glb fixtures/good/oskar.glb fixtures/good/pip.glb fixtures/good/gnu.glb {{assets}}/quaternius-modular-men/Farmer.glb {{assets}}/quaternius-modular-men/Suit.glb {{assets}}/quaternius-modular-men/Swat.glb {{assets}}/valid-avatars/Black_M_1_Casual.glb {{assets}}/makehuman-man/man_casual_12influences.gltf {{assets}}/khronos-rigged/RiggedFigure.glb {{assets}}/nasty/valid/kenney_platformer/character.glb {{assets}}/nasty/valid/InfiniteSkinnedTentacle.glb {{assets}}/obj-spot/cow.obj --ours wedge,refit -o docs/benchmarks/levels-rest.md

# Write docs/benchmarks/crowd.md again: the ways to draw a crowd, side by side, the same triangles without morphs (bake the cast first; two minutes on software Vulkan; exit code 4 while bars are missed)
bench-crowd:
    cargo run --release -p crowdplay -- bench out/cast.crowdpack --ab b0,b1,b2,b3,b4,bucketed --counts 128,1024,8192 --size 640x360 --msaa 1 --rounds 5 --warm-up 1 --no-morph --dots 0 --markdown docs/benchmarks/crowd.md --assert 'bucketed/b0 <= 0.25' --assert 'lod_share:bucketed <= 0.0665' --assert 'vertex_runs:bucketed/b3 <= 0.4' --assert 'runs_per_triangle:bucketed <= 0.9' --assert 'bucketed/b3 <= 0.75' --assert 'bucketed/b4 <= 1.15'

# The same as the player draws, with morphs
bench-crowd-morphs:
    cargo run --release -p crowdplay -- bench out/cast.crowdpack --ab b0,b1,b2,b3,b4,bucketed --counts 128,1024,8192 --size 640x360 --msaa 1 --rounds 5 --warm-up 1 --dots 0 --markdown docs/benchmarks/crowd-morphs.md --assert 'bucketed/b0 <= 0.25' --assert 'lod_share:bucketed <= 0.0665' --assert 'vertex_runs:bucketed/b3 <= 0.4' --assert 'runs_per_triangle:bucketed <= 0.9' --assert 'bucketed/b3 <= 0.75' --assert 'bucketed/b4 <= 1.15'

# Write docs/benchmarks/peng2011.md again: Table 1 of Peng 2011, their method and their baseline beside ours (three minutes on software Vulkan)
bench-peng2011:
    cargo run --release -p crowdplay -- bench out/cast.crowdpack --ab b0,b3,bucketed --counts 32,64,128,256,512,1024,2048,4096,8192 --size 640x360 --msaa 1 --rounds 5 --warm-up 1 --no-morph --dots 0 --markdown docs/benchmarks/peng2011.md

# Write docs/benchmarks/peng2011-linear.md again: Table 2 of Peng 2011, how the time of reformation grows with the triangles
bench-peng2011-linear:
    cargo run --release -p crowdplay -- bench out/cast.crowdpack --ab b3 --counts 2048,4096,8192,16384,32768 --budget-each 200 --size 640x360 --msaa 1 --rounds 9 --warm-up 1 --no-morph --dots 0 --markdown docs/benchmarks/peng2011-linear.md

# Write docs/benchmarks/dong2019.md again: N from 1 to 20 million and 30,000 people, pseudo-instancing and points beside their method and ours (ten minutes on software Vulkan)
bench-dong2019:
    cargo run --release -p crowdplay -- bench out/cast.crowdpack --ab b0,p,b3,bucketed --count 30000 --budgets 1000000,5000000,10000000,20000000 --size 640x360 --msaa 1 --rounds 2 --warm-up 1 --dots 0 --markdown docs/benchmarks/dong2019.md

# Write docs/benchmarks/pops.md again: how much changes from frame to frame by levels alone, on a camera that goes through the crowd
bench-pops:
    cargo run --release -p crowdplay -- bench out/cast.crowdpack --ab b2,b3,bucketed,bucketed+eager,bucketed+jumps --counts 256 --size 640x360 --msaa 4 --rounds 60 --warm-up 1 --camera-path line --dots 0 --budget 100000 --pops --markdown docs/benchmarks/pops.md --assert 'pop_energy:bucketed/b2 <= 0.1' --assert 'pop_energy:bucketed/bucketed+jumps <= 0.25'

# Write docs/benchmarks/million.md again: a crowd of 30,000 and one of 1,000,000 with one budget
bench-million:
    cargo run --release -p crowdplay -- bench out/cast.crowdpack --ab bucketed --counts 30000,1000000 --budget 3600000 --size 640x360 --msaa 1 --rounds 5 --warm-up 1 --markdown docs/benchmarks/million.md --assert 'cpu_share:bucketed <= 0.05' --assert 'lod_share:bucketed <= 0.05'

# Write docs/benchmarks/occlusion.md again: a street with walls at full detail, with and without those whom others hide (bake the cast first)
bench-occlusion:
    cargo run --release -p crowdplay -- bench out/cast.crowdpack --ab bucketed,bucketed+occlusion --layout street --walkable fixtures/scenes/street.wkt --eye=-5,1.7,50 --target=-4,1.2,0 --count 2000 --budget 20000000 --size 640x360 --msaa 1 --rounds 3 --warm-up 2 --skinning vertex --markdown docs/benchmarks/occlusion.md --assert 'triangles:bucketed+occlusion/bucketed <= 0.5' --assert 'bucketed+occlusion/bucketed <= 0.5'

# Write docs/benchmarks/occlusion-field.md again: the same on an open field from above, where nobody is hidden and all of it is overhead
bench-occlusion-field:
    cargo run --release -p crowdplay -- bench out/cast.crowdpack --ab bucketed,bucketed+occlusion --count 8192 --size 640x360 --msaa 1 --rounds 15 --warm-up 2 --skinning vertex --markdown docs/benchmarks/occlusion-field.md --assert 'bucketed+occlusion/bucketed <= 1.03' --assert 'gpu_ms:bucketed+occlusion/bucketed <= 1.03'

# Write docs/benchmarks/shadows.md again: four shadow maps of the sun
bench-shadows:
    cargo run --release -p crowdplay -- bench out/cast.crowdpack --ab bucketed,bucketed+shadows,bucketed+compute,bucketed+compute+shadows --counts 1024,8192 --size 640x360 --msaa 1 --rounds 7 --warm-up 2 --skinning vertex --markdown docs/benchmarks/shadows.md --assert 'bucketed+shadows/bucketed <= 1.6' --assert 'gpu_ms:bucketed+shadows/bucketed <= 1.6'

# Write docs/benchmarks/walkthrough.md again: sixteen frames of the 1,000 of Dong 2019's walk, 30,000 people (three minutes on software Vulkan)
bench-walkthrough:
    cargo run --release -p crowdplay -- bench out/cast.crowdpack --ab b3,bucketed --count 30000 --budget 5000000 --camera-path walkthrough --path 16 --size 640x360 --msaa 1 --warm-up 1 --skinning vertex --dots 0 --markdown docs/benchmarks/walkthrough.md --assert 'mean_runs_per_triangle:bucketed <= 0.9' --assert 'most_runs_per_triangle:bucketed <= 0.9' --assert 'bucketed/b3 <= 0.75'

# Write docs/benchmarks/scene.md again: what the goals are set for, 30,000 people, N of 10 million, along Dong 2019's walk, all the ways to draw (six minutes on software Vulkan)
bench-scene:
    cargo run --release -p crowdplay -- bench out/cast.crowdpack --ab b0,b2,b3,b4,bucketed --count 30000 --budget 10000000 --camera-path walkthrough --path 4 --size 640x360 --msaa 1 --warm-up 1 --skinning vertex --dots 0 --no-morph --markdown docs/benchmarks/scene.md --assert 'bucketed/b0 <= 0.25' --assert 'bucketed/b4 <= 1.15' --assert 'bucketed/b3 <= 0.75' --assert 'lod_share:bucketed <= 0.02' --assert 'vertex_runs:bucketed/b3 <= 0.4' --assert 'mean_runs_per_triangle:bucketed <= 0.9'

# Write docs/benchmarks/equal-image.md again: the triangles with which ours is as near to full detail as three discrete levels are
bench-equal-image:
    cargo run --release -p crowdplay -- bench out/cast.crowdpack --ab b2,bucketed --counts 256,1024,8192 --budget 4000000 --size 640x360 --msaa 1 --rounds 1 --warm-up 1 --skinning vertex --markdown docs/benchmarks/equal-image.md --assert 'triangles_at_equal_image:bucketed/b2 <= 0.6'

# Write docs/benchmarks/park2009.md and park2009-near.md again: Park & Han 2009, a flock of zebras and gnus, 20,000 with a quarter in sight and 5,000 with nine tenths (four minutes on software Vulkan)
bench-park2009:
    cargo run --release -p crowdplay -- bench out/cast.crowdpack --ab b0,b2,bucketed --flock 20000 --simulate gpu --characters zebra,gnu --eye 0,6,20 --target 0,0,-30 --size 640x360 --msaa 1 --rounds 5 --warm-up 1 --no-morph --dots 0 --markdown docs/benchmarks/park2009.md && cargo run --release -p crowdplay -- bench out/cast.crowdpack --ab b0,b2,bucketed --flock 5000 --simulate gpu --characters zebra,gnu --eye 0,16,82 --target 0,0,0 --size 640x360 --msaa 1 --rounds 5 --warm-up 1 --no-morph --dots 0 --markdown docs/benchmarks/park2009-near.md

# Write docs/benchmarks/fades.md again: everyone halfway from one clip to another, for each way to skin
bench-fades:
    cargo run --release -p crowdplay -- bench out/cast.crowdpack --ab bucketed+vertex,bucketed+vertex+fades,bucketed+palettes,bucketed+palettes+fades,bucketed+compute,bucketed+compute+fades --counts 1024,8192 --size 640x360 --msaa 1 --rounds 15 --warm-up 2 --markdown docs/benchmarks/fades.md --assert 'bucketed+palettes+fades/bucketed+palettes <= 1.10' --assert 'bucketed+vertex+fades/bucketed+vertex <= 1.10' --assert 'bucketed+compute+fades/bucketed+compute <= 1.10'

# Write docs/benchmarks/erato.md again: an audience with and without the caches of ERATO, poses held for up to a quarter of a second and shared
bench-erato:
    cargo run --release -p crowdplay -- bench out/cast.crowdpack --ab bucketed+compute,bucketed+compute+rates,bucketed+compute+share,bucketed+vertex --layout seats --counts 500,5000 --pose-rates 30 --no-morph --dots 0 --size 640x360 --msaa 1 --rounds 15 --warm-up 2 --markdown docs/benchmarks/erato.md --assert 'bucketed+compute+share/bucketed+compute <= 1.05'

# Time the simplifier
bench:
    cargo bench -p crowd-lod

# Time whole bakes, beside the order alone and beside meshoptimizer's levels: the table of docs/benchmarks/speed.md (ten minutes, on an idle machine)
bench-bakes assets="../shared/assets":
    cargo bench -p crowdbake --bench whole_bake -- {{assets}}/makehuman-man/man_casual.gltf fixtures/good/mara.glb fixtures/good/oskar.glb fixtures/good/pip.glb fixtures/good/anselm.glb fixtures/good/noor.glb fixtures/good/zebra.glb fixtures/good/gnu.glb

# Licences, bans and sources of the dependencies (needs cargo-deny)
deny:
    cargo deny check licenses bans sources
