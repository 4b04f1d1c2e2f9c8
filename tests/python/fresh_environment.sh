#!/bin/sh
# The package installed from the sources into a virtual environment that has nothing else of ours, used from elsewhere.
set -eu
root=$1 python=$2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
"$python" -m venv --system-site-packages "$scratch/environment"
"$scratch/environment/bin/pip" -q install --no-build-isolation --no-deps --no-index "$root"
cd "$scratch"
environment/bin/python - "$root/data/qzs_256.flac" <<'END'
import pathlib, sys
import ardent

assert pathlib.Path(ardent.__file__).is_relative_to(pathlib.Path(sys.prefix)), ardent.__file__
result = ardent.identify(sys.argv[1], rows=False, figures=False)
assert result.verdict == "describes", result
print(ardent.__version__, repr(result))
END
