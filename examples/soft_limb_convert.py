#!/usr/bin/env python3
"""soft_limb_convert.py LOG.csv FOLDER: a soft limb's log -> detections.csv, frames.csv, servo.csv, heat.csv of tendril.

The log has a row per picture: a time in ms since midnight, duty cycles of the forward and the reverse actuator of two
limbs (fraction) and the centres of the tags in px; 0,0 where a tag was not seen. It holds centres only, so a tag's four
corners are written as its centre. A servo's command is forward less reverse duty; in heat.csv it is how much warmer the forward
actuator is than the reverse one (K), which is what bends the limb. Which thermometer is whose is in no heading: each one
rises when its actuator alone is driven."""
import csv
import os
import sys

LIMBS = ["pwm_duty_limb0", "pwm_duty_limb1"]
THERMOMETERS = [("MCPtemp_1", "MCPtemp_0"), ("MCPtemp_2", "MCPtemp_3")]  # forward, reverse


def main(log, folder):
    os.makedirs(folder, exist_ok=True)
    with open(log, newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["Test time"]]
    tags = sorted(int(name.rsplit("_", 1)[1]) for name in rows[0] if name.startswith("tagid_x_"))

    def write(name, header, lines):
        with open(os.path.join(folder, name), "w") as out:
            out.write(header + "\n")
            out.writelines(",".join(str(cell) for cell in line) + "\n" for line in lines)

    detections, frames, servo, heat = [], [], [], []
    for frame, row in enumerate(rows):
        ns = int(row["Timestamp (millisec since midnight today)"]) * 1_000_000
        frames.append([frame, frame, ns, ns, "ok", 0])
        for tag in tags:
            x, y = row[f"tagid_x_{tag}"], row[f"tagid_y_{tag}"]
            if float(x) != 0 or float(y) != 0:
                detections.append([0, frame, tag, 0, 0] + [x, y] * 4)
        for number, name in enumerate(LIMBS):
            duty = round(float(row[name + "_fwd"]) - float(row[name + "_rev"]), 6)
            servo.append([ns, "", number, duty, "", "", "", ""])
        for number, (forward, reverse) in enumerate(THERMOMETERS):
            if not (row.get(forward) and row.get(reverse)):
                continue  # a log without thermometers, or a row
            heat.append([ns, "", number, round(float(row[forward]) - float(row[reverse]), 6), "", "", "", ""])
    write("detections.csv", "camera,frame,tag,hamming,margin,x0,y0,x1,y1,x2,y2,x3,y3", detections)
    write("frames.csv", "frame,frame_id,device_ns,host_ns,status,dropped_before", frames)
    for name, lines in [("servo.csv", servo), ("heat.csv", heat)]:
        write(name, "host_ns,device_ms,servo,command,position_deg,current_mA,voltage_V,temperature_degC", lines)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2])
