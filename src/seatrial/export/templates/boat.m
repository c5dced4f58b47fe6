function boat = ${name}(p)
%${NAME}  The boat "${vehicle}" as identified; written by ${source}.
%   commands -> allocation -> latency -> curve -> lag -> F = T f -> nu_dot = f(nu, F), eta_dot = R(psi) nu
%
%   boat = ${name}();
%   s = boat.reset();                ${pad}% at rest at the origin
%   s = boat.command(s, ${example}); % ${inputs}; held until the next one
%   s = boat.step(s, 0.01);          ${pad}% advance by 0.01 s
%   s.x                              ${pad}% x, y [m], psi [rad], u, v [m/s], r [rad/s]; may be set
%   boat.rate(s.x, F)                ${pad}% x_dot under forces F = [${forces}], for ode45
%   p = boat.parameters; p.${first} = 0; boat = ${name}(p);   % another boat
%
%   Axes ${axes}; SI units, radians; commands and forces in command units (1: full).${angles}
%   Coefficients are per unit mass and inertia. Runge-Kutta of fourth order with a step
%   boundary at each command, as in seatrial's core. MATLAB from R2016b, Octave from 6.
  if nargin < 1
    p = parameters();
  end
  boat.parameters = p;
  boat.reset = @() reset(p);
  boat.command = @(s, command) give(p, s, command);
  boat.step = @(s, dt) step(p, s, dt);
  boat.rate = @(x, F) rate(p, x, F);
end

function p = parameters()
  % value, standard error, unit
${parameters}
end

function f = allocate(command)
  % Actuator commands for commands to the boat: ${actuators}.
${allocation}
end

function target = curves(p, f)
  % Steady thrust of each actuator for its command.
  target = f;
${curves}
end

function F = mix(f)
  % Generalised forces ${forces}.
  T = ${T};
${turned}
end

function nu_dot = acceleration(p, nu, F)
  % At nu = [u; v; r] under F [m/s^2, m/s^2, rad/s^2].
${acceleration}
end

function x_dot = rate(p, x, F)
  c = cos(x(3));
  s = sin(x(3));
  x_dot = [c * x(4) - s * x(5); s * x(4) + c * x(5); x(6); acceleration(p, x(4:6), F)];
end

function x = runge_kutta(p, h, F, x)
  % One step of h [s], with F at its begin, middle and end in columns.
  k1 = rate(p, x, F(:, 1));
  k2 = rate(p, x + 0.5 * h * k1, F(:, 2));
  k3 = rate(p, x + 0.5 * h * k2, F(:, 2));
  k4 = rate(p, x + h * k3, F(:, 3));
  x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
end

function s = ${whole}(p, s, len)
  % Boat and thrusters over len [s] with constant targets${smooth}.
  n = max(1, ceil(len / ${longest_step} - 1e-9));
  h = len / n;
${prepare}
  for i = 1:n
    away = s.level - s.target;
    level = [s.target + begin .* away, s.target + middle .* away, s.target + final .* away];
${levels}    s.level = level(:, 3);
    s.x = runge_kutta(p, h, mix(${gain}level), s.x);
  end
end

function [begin, middle, final] = fade(h, lag)
  % Decay by a lag of the distance to the target: at the end, and at begin and middle such that a
  % Runge-Kutta step has its exact integrals in velocity and position.
  x = h ./ max(lag, 1e-6);
  share = -expm1(-x) ./ x;
  moment = (1 - share) ./ x;
  few = x < 1e-2;
  y = x(few);
  share(few) = 1 - y .* (1 / 2 - y .* (1 / 6 - y .* (1 / 24 - y .* (1 / 120 - y / 720))));
  moment(few) = 1 / 2 - y .* (1 / 6 - y .* (1 / 24 - y .* (1 / 120 - y .* (1 / 720 - y / 5040))));
  final = exp(-x);
  middle = (6 * share - final - 6 * moment) / 2;
  begin = 12 * moment - 6 * share + final;
  begin(lag <= 1e-6) = 0;
  middle(lag <= 1e-6) = 0;
  final(lag <= 1e-6) = 0;
end

function s = arrive(p, s)
  % The newest command whose latency has passed is an actuator's target.
  [latency, of] = latencies(p);
  for i = 1:numel(latency)
    while s.arrived(i) < numel(s.given_at) && s.given_at(s.arrived(i) + 1) + latency(i) <= s.time
      s.arrived(i) = s.arrived(i) + 1;
      target = curves(p, allocate(s.given(:, s.arrived(i))));
      s.target(of == i) = target(of == i);
    end
  end
  done = min(s.arrived);
  s.given_at = s.given_at(done + 1:end);
  s.given = s.given(:, done + 1:end);
  s.arrived = s.arrived - done;
  still = lags(p) <= 1e-6${free};
  s.level(still) = s.target(still);
end

function [latency, of] = latencies(p)
  % Distinct latencies [s], and the index of each actuator's.
  latency = max(0, [${latencies}]);
  of = [${latency_of}]';
end

function lag = lags(p)
  % [s] of each actuator.
  lag = [${lags}]';
end

function s = give(p, s, command)
  command = command(:);
  if numel(command) ~= ${INPUTS} || ~all(isfinite(command))
    error('${name}: a command is ${INPUTS} finite numbers: ${inputs_text}');
  end
  s.given_at(end + 1) = s.time;
  s.given(:, end + 1) = command;
  s = arrive(p, s);
end

function s = step(p, s, dt)
  if ~(dt >= 0 && isfinite(dt))
    error('${name}: a step is a time >= 0 [s]');
  end
  finish = s.time + dt;
  [latency, ~] = latencies(p);
  while s.time < finish
    next = finish;
    for i = 1:numel(latency)
      if s.arrived(i) < numel(s.given_at)
        next = min(next, s.given_at(s.arrived(i) + 1) + latency(i));
      end
    end
    s = advance(p, s, next - s.time);
    s.time = next;
    s = arrive(p, s);
  end
end

function s = reset(p)
  % Thrusters settled at command 0.
  s.time = 0;
  s.x = zeros(6, 1);
  s.target = curves(p, allocate(zeros(${INPUTS}, 1)));
  s.level = s.target;
${scales}  s.given_at = zeros(1, 0);
  s.given = zeros(${INPUTS}, 0);
  s.arrived = zeros(1, ${LATENCIES});
end
