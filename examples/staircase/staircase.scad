// SPDX-License-Identifier: GPL-3.0-or-later
// The staircase of Cakir's thesis (Bath 1989): a polygon in (x, z) swept over y = 0..60 mm; 15 faces on 14 planes.
// nominal.csg:        openscad -o nominal.csg staircase.scad
// actual.csg:         openscad -o actual.csg -D riser_out_mm=0.4 staircase.scad   (the riser x = 60 stands 0.4 mm out)
// actual_broken.csg:  openscad -o actual_broken.csg -D riser_out_mm=0.4 -D edge_off_mm=4 staircase.scad
//                     (and the lowest step has lost its edge: 4 mm are broken off all along it)
riser_out_mm = 0;
edge_off_mm = 0;
translate([0, 60, 0])
  rotate([90, 0, 0])
    linear_extrude(60)
      polygon(concat([[0, 0], [80, 0]], edge_off_mm > 0 ? [[80, 20 - edge_off_mm], [80 - edge_off_mm, 20]] : [[80, 20]],
                     [[60 + riser_out_mm, 20], [60 + riser_out_mm, 40], [40, 40], [40, 50],
                      [20, 50], [20, 60], [0, 60], [0, 40], [30, 10], [0, 10]]));
