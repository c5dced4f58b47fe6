// SPDX-License-Identifier: MIT
// What runs on board, used once where exceptions and type information are switched off.
#pragma once

double drive_without_exceptions();
double drive_with_sensitivities(double* slope);
double mimic_without_exceptions();
double allocate_without_exceptions();
