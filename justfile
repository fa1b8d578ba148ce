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

# Write docs/BENCHMARKS.md again: our levels and other simplifiers' side by side (gltfpack where it is on PATH)
compare assets="../shared/assets":
    cargo run --release -p crowdbake -- compare {{assets}}/khronos-cesium-man/CesiumMan.glb {{assets}}/khronos-fox/Fox.glb {{assets}}/kaykit-adventurers/Knight.glb {{assets}}/kaykit-adventurers/Mage.glb {{assets}}/gdquest-gdbot/gdbot.glb {{assets}}/makehuman-man/man_casual.gltf fixtures/good/mara.glb fixtures/good/zebra.glb -o docs/BENCHMARKS.md

# Time the simplifier
bench:
    cargo bench -p crowd-lod

# Licences, bans and sources of the dependencies (needs cargo-deny)
deny:
    cargo deny check licenses bans sources
