% typed: equations typed by the user
%    x'' = -x + mu*(1 - x^2)*vx
% by rk4: the classical Runge-Kutta method: fourth order, slightly dissipative
% dt = 0.01 s, from t = 0 s to 10 s; written by hooke 0.1.0
% octave FILE.m >run.csv

mu = 2;

dt = 0.01; % [s] time step
steps = 1000;

acceleration = @(x, vx) -x + mu*(1 - x^2)*vx;

t = 0; % [s]
x = 1;
vx = 0;
rows = zeros(steps + 1, 3);
rows(1, :) = [t, x, vx];
for i = 1:steps
    a1 = acceleration(x, vx);
    x_at2 = x + dt*0.5*vx;
    vx_at2 = vx + dt*0.5*a1;
    a2 = acceleration(x_at2, vx_at2);
    x_at3 = x + dt*0.5*vx_at2;
    vx_at3 = vx + dt*0.5*a2;
    a3 = acceleration(x_at3, vx_at3);
    x_at4 = x + dt*vx_at3;
    vx_at4 = vx + dt*a3;
    a4 = acceleration(x_at4, vx_at4);
    x = x + (dt*(1/6)*vx + dt*(1/3)*vx_at2 + dt*(1/3)*vx_at3 + dt*(1/6)*vx_at4);
    vx = vx + (dt*(1/6)*a1 + dt*(1/3)*a2 + dt*(1/3)*a3 + dt*(1/6)*a4);
    if ~(abs(x) <= 1e150 && abs(vx) <= 1e150)
        warning('diverged after t = %g', t);
        break
    end
    t = i*dt;
    rows(i + 1, :) = [t, x, vx];
end
printf('t,x,vx\n');
printf('%.17g,%.17g,%.17g\n', rows');
% plot(rows(:, 1), rows(:, 2)); xlabel('t [s]');
