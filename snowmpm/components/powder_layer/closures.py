"""Closures of the powder layer: formulas that plain Python and kernels both take, each with its source.

None of them was measured on a powder avalanche. Those of air entrainment are of turbidity currents; those of suspension
are chosen, not measured.
"""

AIR_DENSITY = 1.3
"""rho_a [kg/m3], of cold air at 1000 m or so."""
ICE_DENSITY = 917.0
"""rho_i [kg/m3]."""
AIR_VISCOSITY = 1.33e-5
"""Kinematic viscosity of air [m2/s]."""

SHAPE = {"uniform": (1.0, 1.0, 1.0, 1.0, 1.0), "motpsa": (1.0704, 1.1446, 1.2722, 1.96, 2.6133)}
"""Factors of the profiles over the height, zeta = z/h from 0 to 1: <cu>, <uu>, <cuu>, and u^2 and c u^2 at zeta = 0,
each over those of the means. uniform: c and u are the same at all heights. motpsa: c/c_mean = 4/3 - 2/3 zeta, u/u_mean
= 1.4 + 0.1333 zeta - 1.4 zeta^2, as MoT-PSA has them (parameters that AvaFrame's com8MoTPSA passes; the mean of either
is 1)."""


def no_air(richardson):
    """No air is taken in."""
    return 0.0 * richardson


def parker_1986(richardson):
    """e_a = 0.00153 / (0.0204 + Ri) [-]: air taken in over speed. Parker, Fukushima, Pantin (1986), eq. 19,
    doi:10.1017/S0022112086001404. Ri = R g_n c h / u^2, R = (rho_i - rho_a) / rho_a."""
    return 0.00153 / (0.0204 + richardson)


def parker_1987(richardson):
    """e_a = 0.075 / sqrt(1 + 718 Ri^2.4) [-]. Parker et al. (1987), doi:10.1080/00221688709499292; three times
    `parker_1986` at Ri = 0.1."""
    return 0.075 / (1.0 + 718.0 * richardson**2.4) ** 0.5


AIR = {"parker_1986": parker_1986, "parker_1987": parker_1987, "none": no_air}
"""Air entrainment by its name."""


def no_suspension(state, rate, threshold):
    """Nothing leaves the flow."""
    return 0.0 * state[0]


def by_speed(state, rate, threshold):
    """m12 = rate rho_1 |u_1| [kg/m2/s]. Chosen: the simplest law by which a faster flow gives more dust."""
    return rate * state[0] * state[1]


def by_shear_excess(state, rate, threshold):
    """m12 = rate max(0, tau - tau_c) / |u_1 - u_2| [kg/m2/s], tau = C_12 rho_2 |u_1 - u_2|^2: at rate 1 mass is
    exchanged as momentum is. The analogy is that of SAMOS (Sampl, Zwinger 2004, doi:10.3189/172756404781814780); tau_c
    and the form of the excess are chosen."""
    return rate * max(0.0, state[3] - threshold) / max(state[2], 1e-3)


SUSPENSION = {"speed": by_speed, "shear_excess": by_shear_excess, "none": no_suspension}
"""Suspension by its name: of ((rho_1 [kg/m3], |u_1|, |u_1 - u_2| [m/s], tau [Pa]), rate [-], threshold [Pa])."""
USUAL_RATE = {"speed": 1e-3, "shear_excess": 1.0, "none": 0.0}
"""Their rates where the scene gives none [-]; chosen."""


def uniform_bed(ratio):
    """c at the bed over the mean: 1."""
    return 0.0 * ratio + 1.0


def parker_bed(ratio):
    """r_0 = 1 + 31.5 (u* / w_s)^-1.46, concentration at the bed over the mean. Parker (1982), used by Parker,
    Fukushima, Pantin (1986). u* / w_s below 1 is taken for 1: at rest the formula has no bound."""
    return 1.0 + 31.5 * max(1.0, ratio) ** -1.46


BED = {"parker_1986": parker_bed, "uniform": uniform_bed}
"""Concentration at the bed over the mean, by its name."""


def fall_speed(diameter, gravity=9.81, density=ICE_DENSITY, air=(AIR_DENSITY, AIR_VISCOSITY)):
    """Speed [m/s] at which a sphere of a diameter [m] and density [kg/m3] falls in still air (density, kinematic
    viscosity), by the drag of Schiller and Naumann (1935), C_D = 24/Re (1 + 0.15 Re^0.687) up to Re = 1000, then 0.44:

        w^2 = 4/3 g d (rho_i - rho_a) / (rho_a C_D)

    The law of Stokes, C_D = 24/Re, is 1.2, 1.7, 3.8 and 8 times too fast at 0.1, 0.2, 0.5 and 1 mm.
    """
    drive = 4.0 / 3.0 * gravity * diameter * (density - air[0]) / air[0]
    low, high = 0.0, 100.0
    for _ in range(100):  # w^2 C_D grows with w but for a step of 3 % at Re = 1000
        w = 0.5 * (low + high)
        reynolds = w * diameter / air[1]
        drag = 24.0 / reynolds * (1.0 + 0.15 * reynolds**0.687) if reynolds < 1000.0 else 0.44
        low, high = (w, high) if w * w * drag < drive else (low, w)
    return 0.5 * (low + high)
