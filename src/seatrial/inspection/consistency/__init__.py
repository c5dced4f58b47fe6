# SPDX-License-Identifier: MIT
"""Consistency of a vehicle file with recordings: units, signs and order of poses and commands.

A hypothesis is one reading of the file's columns: another unit of heading or length, coordinates
negated or exchanged, inputs negated or permuted. Two tests rank the hypotheses:

- readings of the poses by the acceleration that they leave unexplained (`pose_units`);
- readings of the inputs by the gains that they imply (`hypotheses`): the gain of a force along its
  own axis is positive.

The check reports the fewest edits of the vehicle file that explain the data.

Recordings do not determine: a mirror image of poses and commands together; which of the two is
mirrored where one is; the order of inputs that enter only as a sum; the sign of an input that is
hardly excited (the report names it).
"""
