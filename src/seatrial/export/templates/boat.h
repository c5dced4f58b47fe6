/* ${name}.h: the boat "${vehicle}" as identified; written by ${source}.
 *
 *   commands -> allocation -> latency -> curve -> lag -> F = T f -> nu_dot = f(nu, F), eta_dot = R(psi) nu
 *
 *     ${name}_boat boat;
 *     const double command[${INPUTS}] = {${example}};  ${input_comment}
 *     ${name}_reset(&boat);
 *     ${name}_command(&boat, command);        held until the next one
 *     ${name}_step(&boat, 0.01);              advance by 0.01 s
 *     printf("%g m/s\n", boat.x[${NAME}_U]);
 *
 * Axes ${axes}; SI units, radians; commands and forces F in command units (1: full).${angles}
 * Coefficients are per unit mass and inertia. C99 and C++; no heap, nothing global, one header of the
 * standard library. Runge-Kutta of fourth order with a step boundary at each command, as in seatrial's core.
 */
#ifndef ${NAME}_H
#define ${NAME}_H
#include <math.h>
#include <string.h>

/* Coefficients: value, standard error, unit. */
${coefficients}
${constants}
enum { ${NAME}_X, ${NAME}_Y, ${NAME}_PSI, ${NAME}_U, ${NAME}_V, ${NAME}_R, ${NAME}_STATES };
enum { ${NAME}_COMMANDS = ${INPUTS}, ${NAME}_ACTUATORS = ${ACTUATORS}, ${NAME}_FORCES = ${FORCES} };
#define ${NAME}_LONGEST_STEP ${longest_step} /* [s] of the integrator */
${sizes}
/* The boat and its thrusters at an instant. */
typedef struct {
  double time;                       /* [s] since reset */
  double x[${NAME}_STATES];          /* x, y [m], psi [rad], u, v [m/s], r [rad/s]; may be set */
  double level[${NAME}_ACTUATORS];   /* thrust after the lag, in command units${radians} */
  double target[${NAME}_ACTUATORS];  /* what the level tends to */${members}
} ${name}_boat;

/* Actuator commands for commands to the boat. */
static inline void ${name}_allocate(const double command[${NAME}_COMMANDS], double f[${NAME}_ACTUATORS]) {
${allocation}
}
${curve_functions}
/* Steady thrust of each actuator for its command. */
static inline void ${name}_curves(const double f[${NAME}_ACTUATORS], double target[${NAME}_ACTUATORS]) {
${curves}
}

/* Generalised forces F = T f. */
static inline void ${name}_mix(const double f[${NAME}_ACTUATORS], double F[${NAME}_FORCES]) {
${mix}
}
${solve_function}
/* nu_dot [m/s^2, m/s^2, rad/s^2] at nu = {u, v, r} [m/s, m/s, rad/s] under F. */
static inline void ${name}_acceleration(const double nu[3], const double F[${NAME}_FORCES], double nu_dot[3]) {
${acceleration}
}

/* x_dot of the whole state under F. */
static inline void ${name}_rate(const double x[${NAME}_STATES], const double F[${NAME}_FORCES],
                                double x_dot[${NAME}_STATES]) {
  const double c = cos(x[${NAME}_PSI]), s = sin(x[${NAME}_PSI]);
  x_dot[${NAME}_X] = c * x[${NAME}_U] - s * x[${NAME}_V];
  x_dot[${NAME}_Y] = s * x[${NAME}_U] + c * x[${NAME}_V];
  x_dot[${NAME}_PSI] = x[${NAME}_R];
  ${name}_acceleration(x + ${NAME}_U, F, x_dot + ${NAME}_U);
}

/* One Runge-Kutta step of h [s], with F at its begin, middle and end. */
static inline void ${name}_runge_kutta(double h, double F[3][${NAME}_FORCES], double x[${NAME}_STATES]) {
  static const double share[4] = {0.0, 0.5, 0.5, 1.0};
  static const double weight[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
  static const int node[4] = {0, 1, 1, 2};
  double at[${NAME}_STATES], k[${NAME}_STATES] = {0.0}, sum[${NAME}_STATES] = {0.0};
  int stage, i;
  for (stage = 0; stage < 4; ++stage) {
    for (i = 0; i < ${NAME}_STATES; ++i) at[i] = x[i] + share[stage] * h * k[i];
    ${name}_rate(at, F[node[stage]], k);
    for (i = 0; i < ${NAME}_STATES; ++i) sum[i] += weight[stage] * k[i];
  }
  for (i = 0; i < ${NAME}_STATES; ++i) x[i] += h * sum[i];
}

/* Boat and thrusters over length [s] with constant targets${smooth}. */
static inline void ${name}${whole}(${name}_boat* boat, double length) {
  const int n = length > ${NAME}_LONGEST_STEP ? (int)ceil(length / ${NAME}_LONGEST_STEP - 1e-9) : 1;
  const double h = length / n;
  double thrust[3][${NAME}_ACTUATORS], F[3][${NAME}_FORCES];
  int i, k;
${prepare}  for (i = 0; i < n; ++i) {
    for (k = 0; k < ${NAME}_ACTUATORS; ++k) {
${levels}
    }
    for (k = 0; k < 3; ++k) ${name}_mix(thrust[k], F[k]);
    ${name}_runge_kutta(h, F, boat->x);
  }
}
${parts_function}
${queue}
/* Current thrust of each actuator, in command units${radians}. */
static inline void ${name}_thrust(const ${name}_boat* boat, double thrust[${NAME}_ACTUATORS]) {
${thrusts}
}

/* At rest at the origin, thrusters settled at command 0. */
static inline void ${name}_reset(${name}_boat* boat) {
  const double still[${NAME}_COMMANDS] = {0.0};
  double f[${NAME}_ACTUATORS];
  memset(boat, 0, sizeof *boat);
  ${name}_allocate(still, f);
  ${name}_curves(f, boat->target);
  memcpy(boat->level, boat->target, sizeof boat->level);
${reset}}

#endif
