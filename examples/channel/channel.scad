// SPDX-License-Identifier: GPL-3.0-or-later
// A channel of U section, 60 mm long, square: turned by half a turn about the vertical it is itself.
// nominal.csg: openscad -o nominal.csg channel.scad
// actual.csg:  openscad -o actual.csg -D tilt_deg=0.4 channel.scad   (the inner wall y = 12 leans by 0.4 degrees into the slot)
tilt_deg = 0;
lean_mm = 28 * tan(tilt_deg);
rotate([90, 0, 90])
  linear_extrude(60)
    polygon([[0, 0], [56, 0], [56, 40], [44, 40], [44, 12], [12, 12], [12 + lean_mm, 40], [0, 40]]);
