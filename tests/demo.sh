#!/usr/bin/env bash
# What ./dev demo runs: heat, a wave and an interpolation on the Stanford bunny, or on the mesh that is given.
# usage: demo.sh PROGRAM [MESH]
set -euo pipefail
program=$1
mesh=${2:-/usr/share/glmark2/models/bunny.obj}
out=$PWD/demo
mkdir -p "$out"

# Vertices of the demonstration: the first, and one a half and three quarters through the file.
count=$("$program" info "$mesh" --json | grep -m1 '"vertices"' | tr -dc 0-9)
a=0
b=$((count / 2))
c=$((count * 3 / 4))

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
