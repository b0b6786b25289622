"""What parameters, their settings and signals of a diagnosis are called where people meet them."""

from __future__ import annotations

from typing import Any

LABELS = {
    "first_per_K": "amplitude, first order",
    "second_per_K": "amplitude, second order",
    "gains_s_per_h": "gains",
    "kick": "kick at each",
    "decades": "time constants span, in decades",
    "saturation_m": "move from which on it kicks fully",
    "source_time_constant_s": "time constant of the rubbing surface",
    "source_share": "share of the rubbing surface itself",
    "renewed": "what earlier moves left",
    "approach": "direction of arrival at the first position of a run",
    "play_m": "way of a reversal",
    "way_m": "way of a reversal",
    "fixed_again": "fixed to the part again",
    "ends_with_run": "it ends",
    "reading_of": "that of",
    "product_of": "that of",
    "weather": "index left out",
    "role": "run for",
}
"""Of parameters whose names alone would not be understood."""

SHARES = {"sensor-detached": "share of the air in it", "air-refraction": "share of the index left out"}
"""Of what a share is one, by the cause."""

CHOICES: dict[tuple[str, Any], str] = {
    ("kick", "direction"): "move, with its sign",
    ("kick", "step"): "move, by its length",
    ("kick", "begin"): "beginning of a run",
    ("renewed", 1.0): "wiped out by each move",
    ("fixed_again", 1): "before the next run",
    ("ends_with_run", 1): "with its run",
    ("weather", "pressure"): "of the pressure alone",
    ("weather", "temperature"): "of the temperature alone",
    ("approach", 0.0): "not known",
    ("approach", 1.0): "from below",
    ("approach", -1.0): "from above",
    ("approach", 0.5): "partly from below",
    ("approach", -0.5): "partly from above",
}
"""What a setting of a parameter is called where its own word would not be understood."""

SIGNALS = {
    "followed": ("what {follows} explains beside the law", "µm", 1e6),
    "time": ("time since the {zero} began", "h", 1.0 / 3600.0),
    "q": ("displacement of the rod", "mm", 1e3),
    "direction": ("direction of the last move", "", 1.0),
    "dT": ("temperature of {sensor} since the zero", "K", 1.0),
    "rate": ("rate of the temperature of {sensor}", "K/h", 3600.0),
    "since_move": ("time since the last move", "min", 1.0 / 60.0),
    "air": ("air temperature", "°C", 1.0),
    "pressure": ("air pressure", "hPa", 1e-2),
    "humidity": ("relative humidity", "%", 1e2),
}
"""What each signal of a residual is called, the unit that is shown, and its factor."""
