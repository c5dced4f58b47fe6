/* A command, held until the next one. Returns 0 without change where it is not finite. */
static inline int ${name}_command(${name}_boat* boat, const double command[${NAME}_COMMANDS]) {
  double f[${NAME}_ACTUATORS];
  int i;
  for (i = 0; i < ${NAME}_COMMANDS; ++i) {
    if (!(fabs(command[i]) < HUGE_VAL)) return 0;
  }
  ${name}_allocate(command, f);
  ${name}_curves(f, boat->target);
${settle}  return 1;
}

/* Advance by dt >= 0 [s]. Returns 0 where dt is invalid, or the state is not finite. */
static inline int ${name}_step(${name}_boat* boat, double dt) {
  int i;
  if (!(dt >= 0.0 && dt < HUGE_VAL)) return 0;
  if (dt > 0.0) ${name}_advance(boat, dt);
  boat->time += dt;
  for (i = 0; i < ${NAME}_STATES; ++i) {
    if (!(fabs(boat->x[i]) < 1e9)) return 0;
  }
  return 1;
}
