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
% ---- multiplier
function m = multiplier(known, reference, power)
  % Factor of a known signal on thrust: 0 where it is not positive.
  m = (max(known, 0) / reference)^power;
end
