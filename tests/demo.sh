#!/usr/bin/env bash
# What ./dev demo runs: heat, a wave and an interpolation on the Stanford bunny, or on the mesh that is given.
# usage: demo.sh PROGRAM [MESH]
set -euo pipefail
program=$1
mesh=${2:-/usr/share/glmark2/models/bunny.obj}
out=$PWD/demo
mkdir -p "$out"

# Three vertices of the demonstration, spread over the file; isolated ones, which nothing can move, are passed over.
count=$("$program" info "$mesh" --json | grep -m1 '"vertices"' | tr -dc 0-9)
usable() {
  "$program" wave "$mesh" --impulse "$1=1" --steps 1 --time 1e-9 --solver cg --quiet -o "$out/.try.ply" >/dev/null 2>&1
}
spread=()
for part in 0 8 12 1 2 3 4 5 6 7 9 10 11 13 14 15; do
  vertex=$((count * part / 16))
  [ "${#spread[@]}" -lt 3 ] && usable "$vertex" && spread+=("$vertex")
done
rm -f "$out/.try.ply"
if [ "${#spread[@]}" -lt 3 ]; then
  "$program" heat "$mesh" --source 0=100 -o "$out/heat.ply" # says what is wrong with the mesh
  echo "demo: too few of the mesh's vertices belong to cells" >&2
  exit 2
fi
a=${spread[0]} b=${spread[1]} c=${spread[2]}

show() { printf '\n$ beltrami'; printf ' %s' "$@"; printf '\n'; "$program" "$@"; }

show info "$mesh"
show heat "$mesh" --source "$a=100" --steps 20 --series "$out/heat.pvd" -o "$out/heat.ply" \
  --picture "$out/heat.png" --summary "$out/heat.json"
show wave "$mesh" --impulse "$a=1" --steps 100 --every 5 --series "$out/wave.pvd" -o "$out/wave.ply" \
  --picture "$out/wave.png" --summary "$out/wave.json"
show interpolate "$mesh" --fix "$a=0" --fix "$b=1" --fix "$c=0.5" --free-components keep --laplacian 1 \
  --bilaplacian 0.1 -o "$out/interpolate.ply" --picture "$out/interpolate.png" --summary "$out/interpolate.json"

cat <<END

The results are in $out:
  *.png    pictures to look at
  *.pvd    time series, *.ply fields on the mesh: open them with ParaView or MeshLab
  *.json   what was done
END
