/* [s] Distinct latencies of the actuators, and the index of each actuator's. */
static const double ${name}_latency[${NAME}_LATENCIES] = {${latencies}};
static const int ${name}_latency_of[${NAME}_ACTUATORS] = {${latency_of}};

/* The newest command whose latency has passed is an actuator's target. */
static inline void ${name}_arrive(${name}_boat* boat) {
  double f[${NAME}_ACTUATORS], target[${NAME}_ACTUATORS];
  int i, k;
  for (i = 0; i < ${NAME}_LATENCIES; ++i) {
    for (; boat->arrived[i] != boat->given; ++boat->arrived[i]) {
      const unsigned slot = boat->arrived[i] % ${NAME}_PENDING;
      if (boat->given_at[slot] + ${name}_latency[i] > boat->time) break;
      ${name}_allocate(boat->pending[slot], f);
      ${name}_curves(f, target);
      for (k = 0; k < ${NAME}_ACTUATORS; ++k) {
        if (${name}_latency_of[k] == i) boat->target[k] = target[k];
      }
    }
  }
${settle}}

/* A command, held until the next one. Returns 0 without change where it is not finite or
 * ${pending} are in the queue. */
static inline int ${name}_command(${name}_boat* boat, const double command[${NAME}_COMMANDS]) {
  const unsigned slot = boat->given % ${NAME}_PENDING;
  int i;
  for (i = 0; i < ${NAME}_COMMANDS; ++i) {
    if (!(fabs(command[i]) < HUGE_VAL)) return 0;
  }
  for (i = 0; i < ${NAME}_LATENCIES; ++i) {
    if (boat->given - boat->arrived[i] >= ${NAME}_PENDING) return 0;
  }
  boat->given_at[slot] = boat->time;
  memcpy(boat->pending[slot], command, sizeof boat->pending[slot]);
  ++boat->given;
  ${name}_arrive(boat);
  return 1;
}

/* Advance by dt >= 0 [s]. Returns 0 where dt is invalid, or the state is not finite. */
static inline int ${name}_step(${name}_boat* boat, double dt) {
  const double end = boat->time + dt;
  int i;
  if (!(dt >= 0.0 && dt < HUGE_VAL)) return 0;
  while (boat->time < end) {
    double next = end;
    for (i = 0; i < ${NAME}_LATENCIES; ++i) {
      const double arrival = boat->given_at[boat->arrived[i] % ${NAME}_PENDING] + ${name}_latency[i];
      if (boat->arrived[i] != boat->given && arrival < next) next = arrival;
    }
    ${name}_advance(boat, next - boat->time);
    boat->time = next;
    ${name}_arrive(boat);
  }
  for (i = 0; i < ${NAME}_STATES; ++i) {
    if (!(fabs(boat->x[i]) < 1e9)) return 0;
  }
  return 1;
}
