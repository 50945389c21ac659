"""Sound in water: its speed, and what of it is absorbed, by temperature, salinity and depth."""

from __future__ import annotations

import math


def speed_of_sound(celsius: float, salinity: float, depth: float) -> float:
    """Return the speed of sound in water (m/s): 0 to 35 degrees, salinity 0 to 45 (g/kg), depth 0 to 1000 m.

    H. Medwin, Speed of sound in water: a simple equation for realistic parameters, JASA 58, 1318, 1975.
    """
    t, s = celsius, salinity
    return 1449.2 + 4.6 * t - 0.055 * t**2 + 0.00029 * t**3 + (1.34 - 0.010 * t) * (s - 35.0) + 0.016 * depth


def absorption(kilohertz: float, celsius: float, salinity: float, depth: float, acidity: float = 8.0) -> float:
    """Return the absorption of sound in water (dB/m) by frequency (kHz), temperature, salinity (g/kg), depth (m), pH.

    By boric acid, magnesium sulphate and water itself: M. A. Ainslie and J. G. McColm, A simplified formula for viscous
    and chemical absorption in sea water, JASA 103, 1671, 1998; near Francois and Garrison from 0.1 to 1000 kHz.
    """
    f, t, km = kilohertz, celsius, depth / 1000.0
    boric = 0.78 * math.sqrt(salinity / 35.0) * math.exp(t / 26.0)
    magnesium = 42.0 * math.exp(t / 17.0)
    of_boric = 0.106 * boric * f**2 / (f**2 + boric**2) * math.exp((acidity - 8.0) / 0.56)
    of_magnesium = 0.52 * (1.0 + t / 43.0) * (salinity / 35.0) * magnesium * f**2 / (f**2 + magnesium**2)
    of_water = 0.00049 * f**2 * math.exp(-(t / 27.0 + km / 17.0))
    return 1e-3 * (of_boric + of_magnesium * math.exp(-km / 6.0) + of_water)
