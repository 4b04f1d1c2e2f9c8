
function x = free_run(p, rows, rate_hz, state, start_s, every)
% Displacements of the equations by themselves, at every so many rows. rows: inputs (num_rows x num_inputs) at rate_hz,
% cubic between them. Dormand-Prince 5(4), with every sgn located where it switches, and held there where neither side leads away.
  n = size(rows, 1); h = 1 / rate_hz;
  of_rows = zeros(size(rows));
  of_rows(2:n-1, :) = (rows(3:n, :) - rows(1:n-2, :)) / 2;
  of_rows([1 n], :) = [rows(2, :) - rows(1, :); rows(n, :) - rows(n-1, :)];
  of_rows(3:n-2, :) = (8 * (rows(4:n-1, :) - rows(2:n-3, :)) - (rows(5:n, :) - rows(1:n-4, :))) / 12;
  m.p = p; m.t = start_s; m.y = state(:); m.largest = abs(m.y); m.driven = equation_data().driven;
  m.u = [rows(1, :).' zeros(size(rows, 2), 3)];
  g = switches(m.p, m.t, m.y, inputs_at(m, 0), []);
  m.sides = 1 - 2 * (g(:) < 0);
  for k = find(g(:).' == 0), m = settle(m, 0, k); end
  x = zeros(numel(1:every:n), numel(displacements(m.p, m.t, m.y, rows(1, :), [])));
  for i = 1:n
    if mod(i - 1, every) == 0
      x((i - 1) / every + 1, :) = displacements(m.p, m.t, m.y, rows(i, :), []).';
    end
    if i == n, break; end
    d = rows(i+1, :) - rows(i, :); s = of_rows(i, :); e = of_rows(i+1, :);
    m.u = [rows(i, :); s / h; (3 * d - 2 * s - e) / h^2; (s + e - 2 * d) / h^3].';
    m = advance(m, h);
  end
end

function m = advance(m, h)
  tau = 0;
  while tau < h
    d = h - tau;
    [y, err] = step(m, tau, d);
    while ~(err <= 1)
      d = d / 2;
      if d < 1e-12 * h, error('the motion ends at t = %g s', m.t); end
      [y, err] = step(m, tau, d);
    end
    k = crossed(m, tau + d, y);
    is_last = k == 0 && d == h - tau;
    low = 0;
    for i = 1:60*(k > 0)
      middle = (low + d) / 2;
      z = step(m, tau, middle);
      earlier = crossed(m, tau + middle, z);
      if earlier == 0, low = middle; else, d = middle; k = earlier; y = z; end
    end
    if is_last, tau = h; else, tau = tau + d; end
    m.y = y; m.largest = max(m.largest, abs(y));
    if k > 0, m = settle(m, tau, k); end
  end
  m.t = m.t + h;
end

function u = inputs_at(m, tau)
  u = m.u * [1; tau; tau^2; tau^3];
end

function value = paces(m, t, y, in, sides, held)
% Rates of the arguments of the switches that are held.
  slope = reshape(slopes(m.p, t, y, in, sides), numel(y) + 1, []).';
  value = slope(held, :) * [rates(m.p, t, y, in, sides); 1];
end

function [sides, pulls] = hold(m, tau, y, sides)
% In the place of sides that are 0 those that keep each sgn's argument at zero, one that the others keep there staying
% 0; and by how much the rate of each argument changes with its own side.
  held = find(sides == 0); n = numel(held); pulls = zeros(size(sides));
  if n == 0, return; end
  in = inputs_at(m, tau); t = m.t + tau; a = zeros(n, n + 1);
  at_zero = paces(m, t, y, in, sides, held);
  for k = 1:n
    one = sides; one(held(k)) = 1;
    a(:, k) = paces(m, t, y, in, one, held) - at_zero;
  end
  a(:, n+1) = -at_zero; pulls(held) = diag(a(:, 1:n));
  for i = 1:n
    if ~(abs(a(i, i)) > 1e-9 * abs(pulls(held(i))))
      a(i, :) = 0; a(:, i) = 0; a(i, i) = 1; continue;
    end
    for j = [1:i-1, i+1:n], a(j, :) = a(j, :) - a(j, i) / a(i, i) * a(i, :); end
  end
  sides(held) = a(:, n+1) ./ diag(a(:, 1:n));
end

function dydt = motion(m, tau, y)
  dydt = rates(m.p, m.t + tau, y, inputs_at(m, tau), hold(m, tau, y, m.sides));
end

function [out, err] = step(m, tau, h)
  persistent c a e
  if isempty(c)
    c = [0 1/5 3/10 4/5 8/9 1 1];
    a = zeros(7);
    a(2, 1) = 1/5; a(3, 1:2) = [3/40 9/40]; a(4, 1:3) = [44/45 -56/15 32/9];
    a(5, 1:4) = [19372/6561 -25360/2187 64448/6561 -212/729];
    a(6, 1:5) = [9017/3168 -355/33 46732/5247 49/176 -5103/18656];
    a(7, 1:6) = [35/384 0 500/1113 125/192 -2187/6784 11/84];
    a = a.'; e = [71/57600; 0; -71/16695; 71/1920; -17253/339200; 22/525; -1/40];
  end
  k = zeros(numel(m.y), 7);
  for s = 1:7
    out = m.y + h * (k * a(:, s));
    k(:, s) = motion(m, tau + c(s) * h, out);
  end
  err = max(abs(h * (k * e)) ./ (1e-12 * max(m.largest, abs(out)) + 1e-300));
  if ~all(isfinite(out)), err = Inf; end
end

function k = crossed(m, tau, y)
  g = switches(m.p, m.t + tau, y, inputs_at(m, tau), []);
  sides = hold(m, tau, y, m.sides);
  for k = 1:numel(g)
    if m.sides(k) * g(k) < 0 || (m.sides(k) == 0 && abs(sides(k)) > 1), return; end
  end
  k = 0;
end

function m = settle(m, tau, k)
% The side of switch k on which the motion goes on, and of those that are held and then no longer can be.
  while true
    before = m.sides(k); m.sides(k) = 0;
    [sides, pulls] = hold(m, tau, m.y, m.sides);
    if before ~= 0 && ~(pulls(k) < 0)
      m.sides(k) = -before;
    elseif before == 0 || abs(sides(k)) > 1
      m.sides(k) = 2 * (sides(k) > 0) - 1;
    else
      in = inputs_at(m, tau); g = switches(m.p, m.t + tau, m.y, in, []);
      slope = reshape(slopes(m.p, m.t + tau, m.y, in, m.sides), numel(m.y) + 1, []);
      of_state = slope(1:end-1, k) .* m.driven;
      m.y = m.y - g(k) * of_state / sum(of_state .^ 2);
    end
    sides = hold(m, tau, m.y, m.sides);
    loose = find(m.sides == 0 & abs(sides) > 1, 1);
    if isempty(loose), break; end
    m.sides(loose) = sign(sides(loose));
  end
end

function apart = compare(file)
  data = equation_data();
  table = dlmread(file, ',', 1, 0);
  every = data.run(3);
  num_x = numel(displacements(data.parameters, 0, data.begin, zeros(1, size(table, 2)), []));
  expected = table(1:every:end, end-num_x+1:end);
  x = free_run(data.parameters, table(:, 2:end-num_x), data.run(2), data.begin, data.run(1), every);
  apart = max(max(abs(x - expected)) ./ max(abs(expected)));
  printf_line = sprintf('free run of %g s: at most %.3g of the largest x apart from Ardent''s', ...
                        (size(table, 1) - 1) / data.run(2), apart);
  disp(printf_line);
end
