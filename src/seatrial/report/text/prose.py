# SPDX-License-Identifier: MIT
"""The report's fixed sentences, as HTML; `$horizon` [s] and the like are filled in."""

ALL_WELL = "<p>No open issue: use the model within its envelope.</p>"

USES = "What the model is fit for"

EFFECTS = """Forward-left-up axes. Lever arm: the measured point from the boat's origin. Delay: the age of a
sensor's value at its stamp. Current: velocity of the water over ground, in earth axes. Trim: steady
acceleration in body axes. Wind: steady acceleration in earth axes;
its part across the boat may be larger or smaller in sway. Stated: from the vehicle file."""

NO_EFFECTS = "None was stated or estimated."

AXES_NOTE = """All values are in forward-left-up axes (<i>x</i> forward, <i>y</i> left, yaw positive to the
left)."""

OTHER_AXES = """ The vehicle file and model.yaml are in forward-right-down axes, where some signs are
opposite (last column)."""

SIGNIFICANCE_NOTE = (
    "A coefficient is significant when it is at least {:g} standard errors away from zero."
)

LEAST_SQUARES = """<p class="note">The standard errors are those of least squares. They cover scatter,
including scatter that is correlated over time. They do not cover the bias that pose noise causes: the
regressors are differentiated poses, and their noise attenuates the coefficients, drag most of all.
No interval here shows that bias. R² is low because accelerations from differentiated poses are mostly
noise. Judge the model by its predictions below.</p>"""

KNOWN = """Relative error: standard error over value. Sharp: up to 5 %. Usable: up to 20 % (dashed and dotted
line). Errors of latency, lag and dead zone are relative to 0.1 s and 0.1, or to the value if it is larger.
Of two correlated parameters each is uncertain, and their combination is well determined."""

NOTHING_ESTIMATED = """Nothing was estimated: the model's values are given, without standard errors. The
recordings therefore determine no uncertainty."""

CORRELATIONS = """In per cent. Blue: the estimates of two parameters are negatively correlated."""

ACTUATORS = """From command to thrust: a static curve, flat within the dead zone (dotted edges), then a
latency and a first-order lag. The latency is transport delay plus clock offset, which the data do not
separate; it may be negative. Shaded: 95 % interval from the standard errors."""

ANGLES = """An angle has its own curve, in degrees and with its trim. Its step response is the change of the force
across, at full thrust ahead."""

RECORDED_NOTE = """Excluded poses are not used anywhere. No velocity spans a gap or a jump, and no prediction spans
an interval without commands. A larger mark means more time at that speed and command. The model is
identified there and extrapolates elsewhere. The scatter plots of a recording are a sample of at most
$scatter instants."""

HORIZONS_NOTE = """RMS error with 95 % intervals (block bootstrap), from the state of the model's own filter, as on
board, to the velocity smoothed over all poses; in scores by the stencil from the velocity of five poses,
too. Dotted: noise floor of the poses. Dash-dotted: expected RMS of the model. Dashed: constant velocity, the
baseline without a model."""

ODOMETRY_NOTE = """Odometry: the disturbance force that the filter estimates goes on and fades, as on board while
there are no poses. The other lines are of the model alone."""

PREDICTION = """From every usable pose the recorded commands drive the model open-loop for $horizon s, from the
velocity of the model's own filter. The predicted velocity is drawn beside the measured one at that later
instant, smoothed over all poses (without a filter: the five-point stencil's, start and measured). The plots
open at the $window s with the strongest commands. Drag to zoom in; double-click for the whole run."""

ERRORS = """Errors are measured minus predicted, $horizon s ahead, over the whole run. Histogram: with the
normal density of the same mean and variance. Autocorrelation: predictions that start less than $horizon s
apart overlap, so a perfect model's errors are correlated up to that lag (dotted line). Velocities share
poses over a few more. Beyond that lag the errors stay within the narrow band if they are
white, or within the wide band of overlapping predictions. Mean error against command: a mean away from 0
indicates a wrong thruster curve or a wrong term. Residuals against inputs: the innovations of the model's
filter, correlated with every force. Within the dashed lines no correlation is significant; dotted is the
limit for a single lag."""

HOMOGENEITY = """Each parameter estimated from the poses of a single recording, with the noise of the model, and
its 95 % interval. A recording is left out where its relative error is above 35 %. p: probability of such
differences by chance (Cochran's Q)."""

NO_INFORMATION = "The information of each recording is not available:"

PHYSICS = """One axis at a time, the others held still, at the largest recorded command, at most full command, then
without command until 2 % of the speed is left. Full command of a force is 1, or, where thrusters are commanded one
by one, the sum of their weights in it. Intervals: coefficients drawn from their covariance."""

RISE = "Vertical dotted line: 63 % of the top speed is reached."

GAINS = """Expected information: each manoeuvre is simulated with this model for a minute, with the model's pose
noise and process noise, and added to the information of the recordings. The table lists the manoeuvre that
halves the interval soonest, or a simpler one that takes nearly the same time. In a small pool drive it in
several legs. The result depends on the model: model mismatch invalidates it."""

OTHER_METHOD = """The times hold for the method output-error; other methods need longer."""

NO_GAINS = "The expected information of a manoeuvre can't be computed."

MARKED = """<p class="note">Marked: the axis that dominates a recording, the pairing of the paper's
Table III.</p>"""

SCORES = """<dt>stays constant</dt><dd>RMS error of the constant-velocity prediction over $horizon s, the
baseline without a model.</dd>
<dt>ratio</dt><dd>RMS error divided by that of constant velocity. Below 1 the model improves on the baseline;
0.5 halves the error. It means little in an axis without excitation.</dd>
<dt>RMS error</dt><dd>Of the predicted velocity, from the start of the model's own filter. The true velocity
is known as well as all poses show it: as the smoothed one with its standard error, which is part of the RMS
error.</dd>
<dt>floor</dt><dd>Noise floor: the RMS error of a perfect model, from the noise of the start; at least the
standard error of the smoothed velocity.</dd>
<dt>expected</dt><dd>Expected RMS of the model: noise floor, process noise and parameter covariance. A larger
RMS error means that boat, wind or water changed.</dd>
<dt>excess</dt><dd>Excess over the floor, √(RMS² − floor²): the share of the model itself.</dd>
<dt>bias</dt><dd>Mean of measured minus predicted: wind, a current, an offset of the commands.</dd>
<dt>kurtosis</dt><dd>3 for a normal distribution; a larger value means rare large errors.</dd>
<dt>(seen)</dt><dd>The model was identified from this recording, so its score is optimistic.</dd>
<dt>why errors are not white</dt><dd>Predictions start at every pose and reach $horizon s ahead, so
neighbours overlap. The errors of k-step predictions are a moving average of order k − 1 even for a
perfect model: correlated below lag k, uncorrelated from there on. Smoothed velocities, and those of the
five-point stencil, share poses, so pose noise shows at small lags and around k.</dd>"""

NO_CONSTANTS = "The chain has no constants: commands act at once and in full."

ENVELOPE = """Speeds from the 0.5th to the 99.5th percentile, commands from the lowest to the highest,
of the recordings that the model was identified from."""

DIFFERENCES = """Differences in standard errors of the difference, for independent models. Dotted: 95 % limits of
a single test. Marked: significant after Holm's correction."""

CAUSES_SHORT = "Probability of each cause"

CAUSES = """Each cause is a map from A's coefficients to B's. Mass: every coefficient of an axis is divided by one
factor. Mass off centre: the coupling terms change, too. Battery: all thrust by one factor. One thruster: its
gain alone. Drag: that of each axis by its own velocity, by one factor, as by weeds or a deeper draught. Current:
surge and sway but for thrust, each coefficient by itself, as in a current that was not estimated. None of these:
every coefficient by itself. All are equally probable before the recordings, with changes of 30 % (standard
deviation); Laplace's approximation gives the probabilities. Two of these: any two of mass, battery, one thruster,
drag and current; a tenth as probable before."""

BOTH_HORIZONS = """All recordings together, each model from its own filter to its own smoothed velocity. Dotted:
noise floor of the poses. Dashed: constant velocity. The table: both models from the same starts to the
five-point stencil's velocity."""

HEAD_TO_HEAD = """Both models from the same starts, at the same instants. The start is the mean of both filters,
or the measured velocity where a filter is not available. The interval of the difference is a block
bootstrap of paired errors."""

BOTH_ERRORS = """Errors $horizon s ahead, over the whole run: distribution and autocorrelation. The bands are those
of A's errors: the narrow one of white errors, the wide one of overlapping predictions."""
