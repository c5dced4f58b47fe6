# SPDX-License-Identifier: MIT
"""The report's fixed sentences, as HTML; `$horizon` [s] and the like are filled in."""

ALL_WELL = "<p>Nothing stands out: use the model within its envelope.</p>"

AXES = """All values are in forward-left-up axes (<i>x</i> forward, <i>y</i> left, turning left is
positive)."""

OTHER_AXES = """ The vehicle file and model.yaml are in forward-right-down axes, where some signs are
opposite (last column)."""

TOLD_APART = "A coefficient is distinguishable from zero when it is at least {:g} standard errors away from it."

LEAST_SQUARES = """<p class="note">The standard errors are those of least squares. They cover scatter,
also scatter that is correlated over time, but not the bias that pose noise causes: the poses are
differentiated, so the regressors are noisy too, and that moves the coefficients, drag most of all,
by an amount that no interval here shows. R² is low because accelerations from differentiated poses are mostly
noise; the predictions below are the measure of the model.</p>"""

KNOWN = """Standard error over value. Sharp: known to 5 %. Usable: to 20 % (the dashed and the dotted line).
Errors of latency, lag and dead zone count against 0.1 s and 0.1, or against the value if that is larger. Two
parameters that are correlated are poorly known each, and their combination well."""

NOTHING_ESTIMATED = """Nothing was estimated: the model's values were given, without standard errors. So nothing
can be said of how well the recordings know them."""

CORRELATIONS = """In per cent; blue: as one is larger, the other is smaller."""

ACTUATORS = """What the thrusters make of a command: a static curve, flat within the dead zone (dotted
edges), then a delay (latency: transport and offset of the clocks, which can't be told apart, and may be
negative) and a first-order lag. Shaded: 95 % of what the standard errors allow."""

RECORDED = """Left-out poses are not used anywhere; no velocity reaches over a gap or a jump, and no
prediction over a stretch without commands. Marks are the larger the longer the boat was at that speed under that
command: the model knows the boat there, and guesses elsewhere. The scatter plots of a recording are a sample of
at most $scatter instants."""

HORIZONS = """RMS error with 95 % intervals (bootstrap over blocks of time), from two kinds of start: the
velocity that five poses give, and the one that the model's own filter knows at that instant, as on board.
Dotted: the floor that pose noise sets; dash-dotted: what the model foresees of itself; dashed: a velocity that
stays as it is, what one has without a model."""

PREDICTION = """From every usable pose the model alone is driven for $horizon s by the recorded
commands; its velocity is drawn beside the one measured at that later instant. The plots open at the
busiest $window s: drag over a stretch to zoom in, double-click for the whole run."""

ERRORS = """Errors are measured minus predicted, $horizon s ahead, over the whole run. Histogram: beside a
normal curve. Autocorrelation: predictions that start less than $horizon s apart share what happened in between,
so even a perfect model's errors are correlated up to that lag (dotted line), and over the four poses more that
two differentiated velocities can share; only beyond should they stay within the bands: the narrow one of white
errors, or the wider one of such overlapping errors. Mean error against command: away from 0, the curve of the
thrusters or a term is wrong there. Residuals against inputs: what the model's filter did not foresee from
pose to pose, correlated with every force; within the dashed lines chance explains all of it, dotted is the
limit for one lag alone."""

REPEAT = """What one recording's poses alone would make of each parameter, the noise as it is, with its 95 %
interval. Left out where a recording knows a
parameter to less than 35 %. p: that recordings differ so much by chance (Cochran's Q)."""

NO_INFORMATION = "What each recording says of the parameters is not known:"

PHYSICS = """One axis at a time, the others held still, at the largest recorded command, then without any until
2 % of the speed is left. Intervals: coefficients drawn from their covariance."""

RISE = "Upright dotted line: 63 % of the top speed is reached."

GAINS = """Expected information: each manoeuvre is simulated with this model for a minute, with its own noise of
poses and motion, and added to what is known already. Given is the one that halves the interval soonest, or a
simpler one that is nearly as soon. In a small pool drive it in several legs. Where the model is wrong, so is
this."""

OTHER_METHOD = """It is what the method output-error makes of a drive; others need more."""

NO_GAINS = "What a manoeuvre would tell can't be computed."

MARKED = """<p class="note">Marked: the axis that dominates a recording, the pairing of the paper's
Table III.</p>"""

SCORES = """<dt>stays constant</dt><dd>RMS error of assuming that the velocity $horizon s later is
what it is now: what one has without a model.</dd>
<dt>ratio</dt><dd>RMS error divided by that. Below 1 the model is worth having; 0.5 halves the error.
It tells little where the boat was not driven.</dd>
<dt>floor</dt><dd>What a perfect model would score, because the velocities that it starts from and is
compared with are noisy themselves.</dd>
<dt>foreseen</dt><dd>What the model says that it would score: the floor, the force that it leaves out and its
uncertain coefficients. More than that: the boat, the wind or the water are not what they were.</dd>
<dt>excess</dt><dd>What is left of the RMS error without the floor, √(RMS² − floor²): the model's own
part.</dd>
<dt>bias</dt><dd>Mean of measured minus predicted: wind, a current, an offset of the commands.</dd>
<dt>kurtosis</dt><dd>3 for a normal distribution; more means rare large errors.</dd>
<dt>(seen)</dt><dd>The model was identified from this recording, so its score flatters.</dd>
<dt>why errors are not white</dt><dd>Predictions start at every pose and reach $horizon s ahead, so
neighbours overlap. The errors of k-step predictions are a moving average of order k − 1 even for a
perfect model: correlated below lag k, uncorrelated from there on. The five-point stencil shares poses
between velocities up to four poses apart, so pose noise shows at lags up to 4 and around k.</dd>"""

NO_CONSTANTS = "The chain has no constants: commands act at once and in full."

ENVELOPE = """Speeds from the 0.5th to the 99.5th percentile, commands from the lowest to the highest,
of the recordings that the model was identified from."""

DIFFERENCES = """Differences in standard errors of the difference, were both models independent; dotted: 95 % of
one alone. Marked: beyond chance for the largest of so many (Holm)."""

BOTH_HORIZONS = """All recordings together, each model from the measured velocity (five poses). Dotted: the floor
that pose noise sets; dashed: a velocity that stays as it is."""

AHEAD = """Both models from the same starts (the mean of both filters, or measured velocities where one can't
be had), at the same instants. The interval of the difference is by bootstrap over blocks of time,
of paired errors."""

BOTH_ERRORS = """Errors $horizon s ahead, over the whole run: how often which, and how they are correlated. The
bands are those of A's errors: the narrow one of white errors, the wider one of overlapping predictions."""
