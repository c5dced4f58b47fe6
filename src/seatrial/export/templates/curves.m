% ---- curve
function g = curve(f, edge_forward, edge_reverse, reverse_ratio, power)
  % Thrust for one command: 0 between the edges, 1 at 1, -reverse_ratio at -1.
  edge = edge_forward * (f >= 0) + edge_reverse * (f < 0);
  full = (f >= 0) - reverse_ratio * (f < 0);
  g = full * (max(abs(f) - edge, 0) / (1 - edge))^power;
end
% ---- pair
function g = pair(own, other, dead)
  % Component `own` of a pair's thrust: along the vector, and grows with its length from dead to 1.
  len = hypot(own, other);
  g = 0;
  if len > dead
    g = own / len * (min(len, 1) - dead) / (1 - dead);
  end
end
% ---- table
function g = table(f)
  % Thrust for one command: linear between the points, constant outside.
  command = [${table_command}];
  thrust = [${table_thrust}];
  f = min(max(f, command(1)), command(end));
  i = min(sum(f >= command), numel(command) - 1);
  g = thrust(i) + (f - command(i)) / (command(i + 1) - command(i)) * (thrust(i + 1) - thrust(i));
end
% ---- limited
function s = advance(p, s, len)
  % Boat and actuators over len [s]: parts in which no angle reaches the end of its rate limit.
  while len > 0
    knee = rates(p) .* lags(p) .* (lags(p) > 1e-6);
    past = (abs(s.level - s.target) - knee) ./ rates(p);
    part = min([len; past(rates(p) > 0 & past .* rates(p) > 1e-9)]);
    s = smooth(p, s, part);
    len = len - part;
  end
end

function rate = rates(p)
  % [rad/s] limit of each angle; 0: none.
  rate = [${rates}]';
end

function left = limited(away, rate, lag, h)
  % Of an angle's distance to its target after h [s]: it shrinks at the rate limit, then by the lag.
  knee = rate * lag * (lag > 1e-6);
  free = max(0, h - max(0, abs(away) - knee) / rate);  % [s] below the limit
  left = sign(away) * min(abs(away), max(abs(away) - rate * h, knee));
  if free > 0
    left = left * exp(-free / max(lag, 1e-6)) * (lag > 1e-6);
  end
end
% ---- multiplier
function m = multiplier(known, reference, power)
  % Factor of a known signal on thrust: 0 where it is not positive.
  m = (max(known, 0) / reference)^power;
end
