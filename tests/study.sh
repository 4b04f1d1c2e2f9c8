#!/bin/sh
# The studies that are too long for every change: the paper's section 4 over many seeds, regimes of many programmes,
# and the rig's record on five seeds. What they print is what a report quotes.
set -eu
ardent=build/release/ardent
mkdir -p out/study
build/release/test_ident "[slow]"
build/release/test_apps "[slow]"
build/release/test_apps "[study]"
$ardent -q --force replicate duffing coulomb bouc-wen bouc-wen-2 valanis-1 valanis-2 valanis-3 valanis-4 \
  --seeds 200 --first-seed 9000 -o out/study/section4
for table in 1 2 3 4 5 6 7 8; do
  grep -h -E '^Table|intervals hold|median errors|^bands|^F-RVM of|^fast_rvm .* x ' out/study/section4/table-$table.txt
done
cat out/study/section4/table-?.txt | awk '/intervals hold/ { held += $5; all += $7 }
  END { printf "pooled coverage of 95 %% intervals on exact supports: %.4f of %d\n", held / all, all }'
for seed in 11 12 13 14 15; do
  echo "rig, seed $seed"
  $ardent -q sim qzs --raw -o "out/study/rig-$seed" --seed "$seed" > /dev/null
  sed "s|rig/recording.wav|rig-$seed/recording.wav|" out/qzs.toml > "out/study/qzs-$seed.toml"
  $ardent -q --force run "out/study/qzs-$seed.toml" -o "out/study/matched-$seed" > /dev/null
  rm -f "out/study/rig-$seed/recording.wav"
  $ardent compare "out/study/matched-$seed" --truth "out/study/rig-$seed/truth.json"
done
