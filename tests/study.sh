#!/bin/sh
# The studies that are too long for every change: the paper's section 4 over many seeds, regimes of many programmes,
# the rig's record on five seeds, and a file beyond 4 GiB. What they print is what a report quotes.
set -eu
ardent=build/release/ardent
mkdir -p out/study
build/release/test_dsp "[large]"
build/release/test_dsp "[study]"
build/release/test_ident "[slow]"
build/release/test_ident "[study]"
build/release/test_apps "[slow]"
build/release/test_apps "[study]"
$ardent -q --force replicate duffing coulomb bouc-wen bouc-wen-2 valanis-1 valanis-2 valanis-3 valanis-4 \
  --seeds 200 --first-seed 9000 -o out/study/section4
for table in 1 2 3 4 5 6 7 8; do
  grep -h -E '^Table|intervals hold|median errors|^bands|^F-RVM of|^fast_rvm .* x ' out/study/section4/table-$table.txt
done
cat out/study/section4/table-?.txt | awk '/intervals hold/ { held += $5; all += $7 }
  END { printf "pooled coverage of 95 %% intervals on exact supports: %.4f of %d\n", held / all, all }'

# What recipe and sensors do to the low regime's friction and damping, to the fit, and to what the equations predict.
printf '\n%-8s %-6s %10s %8s   %-21s %s\n' recipe sensors "low: sgn(v)" v "mixed NMSE train/test" "free run low/high"
for sensors in ideal full; do
  $ardent -q --force sim qzs --raw --rate 256 --sensors $sensors -o out/study/rig-$sensors > /dev/null
  sed "s|rig/recording.wav|rig-$sensors/recording.wav|" out/qzs.toml > out/study/qzs-$sensors.toml
  for recipe in paper matched; do
    $ardent -q --force run out/study/qzs-$sensors.toml -o out/study/$recipe-$sensors \
      --set prepare.recipe=$recipe --set 'fit.methods=["fast_rvm"]' > /dev/null
    awk -v recipe=$recipe -v sensors=$sensors '
      /^range / { range = substr($2, 1, length($2) - 1) }
      $2 ~ /^-?[0-9.]/ && $3 == "+-" { mean[range, $1] = $2 }
      /^ *NMSE train/ { gsub(",", ""); train[range] = $3; test[range] = $5; run[range] = $8 }
      END { printf "%-8s %-6s %12.5f %8.4f   %9s %9s     %s %s\n", recipe, sensors, mean["low", "sgn(v)"],
              mean["low", "v"], train["mixed"], test["mixed"], run["low"], run["high"] }' \
      out/study/$recipe-$sensors/details.txt
  done
done

for seed in 11 12 13 14 15; do
  echo "rig, seed $seed"
  $ardent -q --force sim qzs --raw -o "out/study/rig-$seed" --seed "$seed" > /dev/null
  sed "s|rig/recording.wav|rig-$seed/recording.wav|" out/qzs.toml > "out/study/qzs-$seed.toml"
  for recipe in matched paper; do
    $ardent -q --force run "out/study/qzs-$seed.toml" -o "out/study/$recipe-$seed" --set prepare.recipe=$recipe > /dev/null
  done
  rm -f "out/study/rig-$seed/recording.wav"
  $ardent compare "out/study/matched-$seed" "out/study/paper-$seed" --truth "out/study/rig-$seed/truth.json"
done

# Records of kinds that the rules of the verdict were not made for, right and wrong by their labels.
build/release/make_kinds 20261127 out/study/kinds
python3 tests/kinds/judge_kinds.py $ardent out/study/kinds out/study/kinds-runs
