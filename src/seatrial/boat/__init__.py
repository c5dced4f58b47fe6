# SPDX-License-Identifier: MIT
"""The boat as data: structure, actuators, allocation, vehicle file, noise parameters, model; and its physics."""
