/* ---- curve */
/* Thrust for one command: 0 between the edges, 1 at 1, -reverse_ratio at -1. */
static inline double ${name}_curve(double f, double edge_forward, double edge_reverse, double reverse_ratio,
                                   double power) {
  const double edge = f >= 0.0 ? edge_forward : edge_reverse;
  const double past = fabs(f) - edge;
  if (past <= 0.0) return 0.0;
  return (f >= 0.0 ? 1.0 : -reverse_ratio) * pow(past / (1.0 - edge), power);
}
/* ---- pair */
/* Component `own` of a pair's thrust: along the vector, and grows with its length from dead to 1. */
static inline double ${name}_pair(double own, double other, double dead) {
  const double length = hypot(own, other);
  if (length <= dead) return 0.0;
  return own * (length >= 1.0 ? 1.0 : (length - dead) / (1.0 - dead)) / length;
}
/* ---- table */
/* Thrust for one command: linear between the points, constant outside. */
static inline double ${name}_table(double f) {
  static const double command[${points}] = {${table_command}};
  static const double thrust[${points}] = {${table_thrust}};
  int i = 1;
  if (f <= command[0]) return thrust[0];
  if (f >= command[${points} - 1]) return thrust[${points} - 1];
  while (f >= command[i]) ++i;
  return thrust[i - 1] + (f - command[i - 1]) / (command[i] - command[i - 1]) * (thrust[i] - thrust[i - 1]);
}
/* ---- fade */
/* Decay by a lag over h [s] of the distance to the target: at the end, and at begin and middle such
 * that a Runge-Kutta step has its exact integrals in velocity and position. */
static inline void ${name}_fade(double h, double lag, double* begin, double* middle, double* end) {
  const double x = lag > 1e-6 ? h / lag : 1.0;
  const int small = x < 1e-2;
  const double mean = small ? 1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x * (1.0 / 120.0 - x / 720.0))))
                            : -expm1(-x) / x;
  const double moment = small ? 0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x * (1.0 / 120.0 - x * (1.0 / 720.0 - x / 5040.0))))
                              : (1.0 - mean) / x;
  *end = lag > 1e-6 ? exp(-x) : 0.0;
  *middle = lag > 1e-6 ? 0.5 * (6.0 * mean - *end - 6.0 * moment) : 0.0;
  *begin = lag > 1e-6 ? 12.0 * moment - 6.0 * mean + *end : 0.0;
}
/* ---- degree */
#define ${NAME}_DEGREE (3.14159265358979323846 / 180.0) /* [rad] */
/* ---- limited */
/* What is left after h [s] of an angle's distance `away` to its target: it shrinks at the rate limit
 * down to rate * lag, then by the lag. */
static inline double ${name}_limited(double away, double rate, double lag, double h) {
  const double knee = lag > 1e-6 ? rate * lag : 0.0;
  const double until = fmax(fabs(away) - knee, 0.0) / rate;
  const double left = fmin(fabs(away), fmax(fabs(away) - rate * h, knee));
  if (h <= until) return copysign(left, away);
  return lag > 1e-6 ? copysign(left * exp((until - h) / lag), away) : 0.0;
}

/* Of length [s] the part in which it does not reach the end of its rate limit. */
static inline double ${name}_smooth_part(double away, double rate, double lag, double length) {
  const double past = fabs(away) - (lag > 1e-6 ? rate * lag : 0.0);
  return past > 1e-9 ? fmin(past / rate, length) : length;
}
/* ---- parts */

/* Boat and actuators over length [s] with constant targets. */
static inline void ${name}_advance(${name}_boat* boat, double length) {
  while (length > 0.0) {
    double part = length;
${parts}
    ${name}_smooth(boat, part);
    length -= part;
  }
}
/* ---- multiplier */
/* Factor of a known signal on thrust: (signal / reference)^power, 0 where it is not positive. */
static inline double ${name}_multiplier(double signal, double reference, double power) {
  return signal > 0.0 ? pow(signal / reference, power) : 0.0;
}
/* ---- solve */
/* nu_dot = (I - A)^-1 g: solved for accelerations on the right-hand side. */
static inline void ${name}_solve(double A[3][3], const double g[3], double nu_dot[3]) {
  double m[3][3], c[3][3], determinant;
  int i, j;
  for (i = 0; i < 3; ++i) {
    for (j = 0; j < 3; ++j) m[i][j] = (i == j ? 1.0 : 0.0) - A[i][j];
  }
  for (i = 0; i < 3; ++i) {
    for (j = 0; j < 3; ++j) { /* cofactors; indices that go round carry the sign */
      const int a = (i + 1) % 3, b = (i + 2) % 3, p = (j + 1) % 3, q = (j + 2) % 3;
      c[i][j] = m[a][p] * m[b][q] - m[a][q] * m[b][p];
    }
  }
  determinant = m[0][0] * c[0][0] + m[0][1] * c[0][1] + m[0][2] * c[0][2];
  for (i = 0; i < 3; ++i) nu_dot[i] = (c[0][i] * g[0] + c[1][i] * g[1] + c[2][i] * g[2]) / determinant;
}
