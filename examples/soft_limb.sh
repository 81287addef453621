#!/usr/bin/env bash
# From a real soft limb's log to the database: soft_limb.sh LOG.csv [LAB]
# Converts the log, makes a lab if there is none, imports the trial (nine tags, 101 to 109 from the clamped end),
# reconstructs the centerline over time and plots its curvature, with bands and the loop between rising and falling
# actuation: of the whole chain against the duty cycle of limb 0, and of either limb (the tags up to the fifth, which
# sits where they join, and those from it on) against how much warmer its forward actuator is than its reverse one.
# The log states no scale; SPACING_MM is the distance of neighbouring tags and only scales lengths and curvature.
set -euo pipefail
log=${1:?usage: soft_limb.sh LOG.csv [LAB]}
lab=${2:-soft-limb-lab}
spacing_mm=${SPACING_MM:-10}
here=$(cd "$(dirname "$0")" && pwd)
tendril=${TENDRIL:-$here/../tendril}
label=limb-$(date -u +%Y%m%d-%H%M%S)

[ -e "$lab/lab.db" ] || "$tendril" init "$lab"
files=$(mktemp -d)
trap 'rm -rf "$files"' EXIT
python3 "$here/soft_limb_convert.py" "$log" "$files"
"$tendril" trials import --lab "$lab" --label "$label" \
  --detections "$files/detections.csv" --frames "$files/frames.csv" --servo "$files/servo.csv" --source "$log" \
  --chain 101,102,103,104,105,106,107,108,109 --spacing-mm "$spacing_mm" --sigma-px 0.3 \
  --notes "soft limb with nine tags, from $(basename "$log"); tag spacing taken as $spacing_mm mm"
"$tendril" trials show --lab "$lab" "$label"
trial=$lab/trials/$("$tendril" trials show --lab "$lab" "$label" --json | python3 -c 'import json, sys; print(json.load(sys.stdin)["id"])')
"$tendril" plot curvature "$trial/curves.h5" --servo "$trial/servo.csv" \
  --command-label "duty cycle, forward less reverse" --out "$lab/$label-curvature.svg"
[ "$(wc -l < "$files/heat.csv")" -gt 1 ] || exit 0 # no thermometers in the log
for limb in 0 1; do
  "$tendril" plot curvature "$trial/curves.h5" --servo "$files/heat.csv" --servo-number $limb \
    --nodes $((4 * limb)),$((4 * limb + 4)) --command-label "forward less reverse actuator's temperature (K)" \
    --out "$lab/$label-limb$limb-curvature.svg"
done
