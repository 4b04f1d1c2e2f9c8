#!/bin/sh
# The main job of ./run: 1800 s of the rig's raw record, and its equation of motion by both recipes beside the truth.
# Everything goes into out/; the 553 MB raw file is removed at the end unless --keep is given.
set -eu
keep=no
[ "${1-}" != --keep ] || keep=yes
ardent=build/release/ardent
mkdir -p out

echo "simulating 1800 s of the rig at 25.6 kHz, four channels ..."
$ardent -q --force sim qzs --raw -o out/rig --seed 1

cat > out/qzs.toml <<'END'
schema = 1
[[recording]]
file = "rig/recording.wav"
[prepare]
rate_hz = 25.6
cutoff_hz = 10.24
rolloff_hz = 8
[library]
order = 0
terms = ["x", "v", "x^2", "x^3", "sgn(v)", "ddr"]
[[range]]
name = "low"
from = 2.9
to = 830
train_to = 500
[[range]]
name = "high"
from = 1440
to = 1720
train_to = 1560
[[range]]
name = "mixed"
from = 0
to = 1720
train_to = 1000
END

echo "identifying it, columns filtered as the target is (matched) ..."
echo
$ardent -q --force run out/qzs.toml -o out/matched
echo
echo "identifying it, signals filtered first (paper) ..."
$ardent -q --force run out/qzs.toml -o out/paper --set prepare.recipe=paper > /dev/null

echo
echo "Both beside the truth, in the units of the payload's laser, which reads 0.4 % short; inside: the true coefficient is"
echo "within the 95 % interval:"
echo
$ardent -q --force compare out/matched out/paper --truth out/rig/truth.json -o out/compare
$ardent compare out/matched out/paper --truth out/rig/truth.json --method sindy > out/compare-sindy.txt

if [ "$keep" = no ]; then
  rm -f out/rig/recording.wav
  echo "The raw recording was removed (./run --keep keeps it)."
fi
echo "Pages with figures: out/matched/report.html, out/paper/report.html, out/compare/compare.html"
echo "Truth: out/rig/truth.json, out/rig/truth.csv. Prepared signals: out/matched/prepared.csv"
