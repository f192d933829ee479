"""The analyses of gelcone, each once. To add one, write its function and its answers and list it here."""

from __future__ import annotations

from collections.abc import Mapping

from gelcone.errors import unknown_name
from gelcone.register.analysis import Analysis

_ALL = (
    Analysis(
        "simulate",
        "How it moves: time response, stresses, energies, validity.",
        function="motion.response:simulate",
        answers="analyses.trajectories",
        exclusive=(("periods", "times"),),
        examples=(
            "--set voltage=1.04 --set drive_frequency=0.1 --json",
            "paper-table1 --periods 30 --out results",
        ),
    ),
    Analysis(
        "section",
        "Poincare section: the motion once every forcing period.",
        function="motion.section:section",
        answers="analyses.trajectories",
        examples=("--set voltage=1.7 --set drive_frequency=0.1 --repeats 2000 --out results",),
    ),
    Analysis(
        "extrema",
        "The maxima and minima of the displacement.",
        function="motion.section:extrema",
        answers="analyses.trajectories",
        examples=("paper-table1 --json",),
    ),
    Analysis(
        "spectrum",
        "Amplitude spectrum, its lines and its flatness.",
        function="motion.spectrum:spectrum",
        answers="analyses.trajectories",
        examples=(
            "--set voltage=1.7 --set drive_frequency=0.1 --out results",
            "paper-table1 --json",
        ),
    ),
    Analysis(
        "lyapunov",
        "Lyapunov exponents, over a window and in the long run, with errors.",
        function="motion.lyapunov:lyapunov",
        cells="motion.lyapunov:lyapunov_cells",
        answers="analyses.motions",
        bulky=("running_time", "running_exponent", "finite_time", "finite_exponent"),
        examples=(
            "--set voltage=1.7 --set drive_frequency=0.1 --out results",
            "--set voltage=0.5,1,1.5 --budget 5000 --json",
        ),
    ),
    Analysis(
        "regime",
        "What kind of motion it is, with the evidence.",
        function="motion.regime:regime",
        cells="motion.regime:regime_cells",
        answers="analyses.motions",
        kinds=("regime", "sign"),
        bulky=("section",),
        examples=(
            "--set voltage=1.04 --set drive_frequency=0.1 --json",
            'paper-table1 --set "voltage_amplitude=5 kV,8 kV" --out results',
        ),
    ),
    Analysis(
        "static",
        "Equilibria under constant voltage, pitchfork, folds, pull-in, stroke.",
        function="motion.equilibrium:static",
        answers="analyses.statics",
        examples=(
            "--set spring_stiffness=1.5 --voltages 0,1,1.5 --out results",
            'paper-table1 --voltages "0 kV:10 kV:11" --json',
        ),
    ),
    Analysis(
        "limits",
        "Voltages that bound the use: loss of stability of rest, pitchfork, pull-in.",
        function="motion.limits:limits",
        cells="motion.limits:limits_cells",
        answers="analyses.tables",
        examples=(
            "--preset base --set prestretch=0.8:1.2:5",
            "paper-table1 --json",
        ),
    ),
    Analysis(
        "settled",
        "The settled motion: stroke, period, harmonics, and the linear stroke.",
        function="motion.settled:settled",
        cells="motion.settled:settled_cells",
        answers="analyses.tables",
        examples=(
            "biased-pump",
            "--preset spring --set drive_frequency=0.3,0.4 --json",
        ),
    ),
    Analysis(
        "operating_limits",
        "Peak voltages at which film slack, chaos, pull-in and so on begin.",
        function="motion.envelope:operating_limits",
        cells="motion.envelope:operating_limits_cells",
        answers="analyses.tables",
        examples=("biased-pump",),
    ),
    Analysis(
        "tongues",
        "Where the drive makes rest unstable: onset voltage and tongues.",
        function="motion.floquet:tongues",
        answers="analyses.stability",
        over="drive_frequency or voltage (of a device: frequency or voltage_amplitude), with its values as "
        "from:to:count or v1,v2,...; may be given for both.",
        from_over=("frequencies", "voltages"),
        reader="analyses.stability:tongues_arguments",
        single=True,
        examples=(
            "--over drive_frequency=0.2:3:120 --over voltage=0:2:100 --out results",
            "--set damping_ratio=0.01 --set drive_frequency=0.1 --json",
        ),
    ),
    Analysis(
        "bifurcation",
        "What the motion is along one parameter, and where it changes.",
        function="atlas.bifurcation:bifurcation",
        answers="analyses.grids",
        over="The parameter to sweep, or the field of a device: name=from:to:count or name=v1,v2,...",
        reader="analyses.grids:bifurcation_arguments",
        single=True,
        planned=True,
        examples=(
            "--over voltage=0:2:401 --set drive_frequency=0.1 --out results",
            'paper-table1 --over "voltage_amplitude=0 kV:10 kV:101" --sweeps up --json',
        ),
    ),
    Analysis(
        "continue_branch",
        "Branches of periodic orbits, stable or not, and their bifurcations.",
        function="atlas.branches.continuation:continue_branch",
        answers="analyses.branches",
        reader="analyses.branches:continue_branch_arguments",
        called="continue",
        single=True,
        planned=True,
        examples=(
            "voltage 0.9 1.4 --preset base --out results",
            'film_thickness "0.15 mm" "0.25 mm" biased-pump --from settled --json',
            "drive_frequency 0.1 3 --preset spring --set damping_ratio=0.01 --from settled --switch 0",
        ),
    ),
    Analysis(
        "locus",
        "Folds, period doublings or symmetry breakings in two parameters.",
        function="atlas.branches.locus:locus",
        answers="analyses.branches",
        over="One of the two parameters, or fields of a device, NAME=from:to; the second interval holds the value that "
        "is set.",
        reader="analyses.branches:locus_arguments",
        single=True,
        planned=True,
        examples=(
            "fold --preset base --over voltage=0.95:1.5 --over drive_frequency=0.07:0.13 --out results",
            "fold --preset base --over voltage=0.95:1.5 --over drive_frequency=0.07:0.13 --on map.nc --out results",
            "doubling --preset base --over voltage=0.9:1.8 --over hoop_prestretch=0.7:1.4 --set hoop_prestretch=1",
        ),
    ),
    Analysis(
        "map",
        "Exponent and regime over two parameters.",
        function="atlas.maps:map",
        answers="analyses.grids",
        over="A parameter of the map, or a field of a device: name=from:to:count or name=v1,v2,...; give two, the "
        "first one is drawn along x.",
        single=True,
        examples=(
            "--preset base --over voltage=0:2:101 --over prestretch=0.4:2:81 --out results",
            'biased-pump --over "film_thickness=0.1 mm:0.3 mm:41" --over "frequency=5 Hz:20 Hz:61" --out results',
            "--preset base --over voltage=0:2:512 --over prestretch=0.4:2:512 --store map.zarr",
            "--resume map.zarr --out results",
        ),
    ),
    Analysis(
        "sweep",
        "Any analysis over any parameters, and the probability of chaos.",
        function="atlas.sweep:sweep",
        answers="analyses.grids",
        over="A parameter of the grid, or a field of a device: name=from:to:count or name=v1,v2,...; any number.",
        single=True,
        examples=(
            "--preset base --over voltage=0:2:21 --over prestretch=0.6:1.4:5 --over damping_ratio=0.01,0.1",
            "--preset base --over voltage=0.8:1.2:21 --uncertain prestretch=1~0.02 --count 128",
            'soft-film --over "voltage_amplitude=400 V:600 V:5" --uncertain "film_thickness=100 um~5 um"',
        ),
    ),
    Analysis(
        "show",
        "What the store of a map or sweep holds by now.",
        function="atlas.record:show",
        answers="analyses.grids",
        examples=("map.zarr --out results",),
    ),
    Analysis(
        "basin",
        "Which motions coexist: the attractor of each initial state.",
        function="atlas.maps:basin",
        answers="analyses.grids",
        over="Initial displacements or velocities, from:to:count or v1,v2,... (with a device '-5 mm:5 mm:41').",
        reader="analyses.grids:basin_arguments",
        single=True,
        planned=True,
        examples=(
            "--set voltage=1.04 --set drive_frequency=0.1 --out results",
            "--set voltage=1.2 --over displacement=-1:1:41 --over velocity=-1:1:41 --json",
        ),
    ),
    Analysis(
        "frequency",
        "Stroke over drive frequency, swept up and down: resonances and jumps.",
        function="atlas.frequency:frequency",
        answers="analyses.frequency",
        over="The drive frequencies, drive_frequency=from:to:count or =f1,f2,... (device: 'frequency=4 Hz:9 Hz:80').",
        from_over=("frequencies",),
        reader="analyses.frequency:frequency_arguments",
        single=True,
        examples=(
            "biased-pump",
            'biased-pump --over "frequency=4 Hz:20 Hz:80" --out results',
            "--preset spring --set spring_stiffness=0.1 --over drive_frequency=0.2:1:81 --json",
        ),
    ),
    Analysis(
        "envelope",
        "Where a device is safe to drive, and which limit comes first.",
        function="motion.envelope:envelope",
        answers="analyses.envelope",
        over="Drive frequencies or peak voltages in place of the default ones: drive_frequency=from:to:count, "
        "voltage=from:to:count (of a device: 'frequency=5 Hz:20 Hz:31', 'peak_voltage=500 V:2 kV:16').",
        from_over=("peaks", "frequencies"),
        reader="analyses.envelope:envelope_arguments",
        examples=(
            "biased-pump --out results",
            'my-device.toml --over "frequency=5 Hz:20 Hz:31" --margin 0.3 --json',
        ),
    ),
)
ANALYSES: Mapping[str, Analysis] = {analysis.name: analysis for analysis in _ALL}
SWEEPABLE: Mapping[str, Analysis] = {name: analysis for name, analysis in ANALYSES.items() if analysis.cells}


def find_analysis(name: str) -> Analysis:
    """The analysis of that name; `InputError` with the nearest name when there is none."""
    if name not in ANALYSES:
        raise unknown_name("analysis", name, ANALYSES)
    return ANALYSES[name]
