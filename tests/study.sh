#!/bin/sh
# The studies that are too long for every change: the paper's section 4 over many seeds, regimes of many programmes,
# and the rig's record on five seeds. What they print is what a report quotes.
set -eu
ardent=build/release/ardent
mkdir -p out/study
build/release/test_apps "[slow]"
build/release/test_apps "[study]"
$ardent -q replicate all --seeds 20 --first-seed 9000 -o out/study/section4
for seed in 11 12 13 14 15; do
  echo "rig, seed $seed"
  $ardent -q sim qzs --raw -o "out/study/rig-$seed" --seed "$seed" > /dev/null
  sed "s|rig/recording.wav|rig-$seed/recording.wav|" out/qzs.toml > "out/study/qzs-$seed.toml"
  $ardent -q --force run "out/study/qzs-$seed.toml" -o "out/study/matched-$seed" > /dev/null
  rm -f "out/study/rig-$seed/recording.wav"
  $ardent compare "out/study/matched-$seed" --truth "out/study/rig-$seed/truth.json"
done
