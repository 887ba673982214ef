"""Made-up snow profiles in every format: the same snow, a slab of 45 cm over 3 cm of depth hoar on 36 degrees."""

import struct

import numpy as np

LAYERS = (  # top, bottom [cm], form, size [mm], hardness, density
    (0, 15, "PP", 1.0, "F", None),
    (15, 30, "DF", 0.75, "4F", 160.0),
    (30, 45, "RG", 0.4, "1F", None),
    (45, 48, "DH", 2.5, "F", None),
    (48, 90, "MFcr", 1.0, "P", None),
)
TESTS = (("PropSawTest", 45, "<fracturePropagation>End</fracturePropagation><cutLength uom='cm'>32</cutLength>"
                             "<columnLength uom='cm'>100</columnLength>"),
         ("ExtColumnTest", 45, "<testScore>ECTP12</testScore>"))

CSV = """# name = Made-up slope
# slope_angle = 36
# test = PST, depth [cm] 45, cut [cm] 32, column [cm] 100, End
# test = ECT, depth [cm] 45, ECTP12
top [cm], bottom [cm], form, size [mm], hardness, density [kg/m3]
""" + "".join(f"{top}, {bottom}, {form}, {size}, {hardness}, {density or ''}\n"
              for top, bottom, form, size, hardness, density in LAYERS)


def caaml(layers=LAYERS, angle="36", tests=TESTS, version="6.0.3", unit="cm", extra="", density_unit="kgm-3"):
    """Text of a CAAML file."""
    strata = "".join(
        f"<Layer><depthTop uom='{unit}'>{top}</depthTop><thickness uom='{unit}'>{bottom - top}</thickness>"
        f"<grainFormPrimary>{form}</grainFormPrimary><grainSize uom='mm'><Components><avg>{size}</avg></Components>"
        f"</grainSize><hardness uom=''>{hardness}</hardness></Layer>"
        for top, bottom, form, size, hardness, _ in layers)
    densities = "".join(
        f"<Layer><depthTop uom='cm'>{top}</depthTop><thickness uom='cm'>{bottom - top}</thickness>"
        f"<density uom='{density_unit}'>{density}</density></Layer>" for top, bottom, *_, density in layers if density)
    failed = "".join(f"<{kind}><failedOn><Layer><depthTop uom='cm'>{depth}</depthTop></Layer><Results>{results}"
                     f"</Results></failedOn></{kind}>" for kind, depth, results in tests)
    return f"""<?xml version="1.0" encoding="UTF-8"?>{extra}
<SnowProfile xmlns="http://caaml.org/Schemas/SnowProfileIACS/v{version}" xmlns:gml="http://www.opengis.net/gml">
<timeRef><recordTime><TimeInstant><timePosition>2026-01-28T13:00:00</timePosition></TimeInstant></recordTime></timeRef>
<locRef><name>Made-up slope</name>
<validElevation><ElevationPosition uom="m"><position>2100</position></ElevationPosition></validElevation>
<validAspect><AspectPosition><position>N</position></AspectPosition></validAspect>
<validSlopeAngle><SlopeAnglePosition uom="deg"><position>{angle}</position></SlopeAnglePosition></validSlopeAngle>
<pointLocation><gml:Point><gml:pos>46.8 9.8</gml:pos></gml:Point></pointLocation></locRef>
<snowProfileResultsOf><SnowProfileMeasurements dir="top down">
<stratProfile>{strata}</stratProfile>
<tempProfile><Obs><depth uom="cm">0</depth><snowTemp uom="degC">-9</snowTemp></Obs>
<Obs><depth uom="cm">45</depth><snowTemp uom="degC">-4</snowTemp></Obs></tempProfile>
<densityProfile>{densities}</densityProfile>
<stbTests>{failed}</stbTests>
</SnowProfileMeasurements></snowProfileResultsOf></SnowProfile>
"""


PRO = """[STATION_PARAMETERS]
StationName= Made-up station
Latitude= 46.8
Longitude= 9.8
Altitude= 2540
SlopeAngle= 36.00
SlopeAzi= 0.00

[HEADER]
0500,Date
0501,nElems,height [> 0: top, < 0: bottom of elem.] (cm)

[DATA]
0500,01.10.2025 00:00:00
0501,1,0
0500,28.01.2026 12:00:00
0501,7,-20,0,42,45,60,75,90
0502,6,1500,400,210,220,160,80
0503,6,2,-1,-3,-4,-6,-9
0512,5,1.0,2.5,0.4,0.75,1.0
0513,6,772,550,330,220,110,660
0534,5,4,1,3,2,1
"""
"""One step without snow, then 20 cm of soil below five elements of snow; sizes and hardness of snow alone."""


def pnt(layers=((0.3, 150.0), (0.5, 300.0), (0.05, 300.0), (0.6, 300.0)), each=60.0, spacing=0.01, seed=1):
    """Bytes of a file of a SnowMicroPen: air, then layers of `each` [mm] of a mean force [N] and shots a millimetre."""
    rng = np.random.default_rng(seed)
    n = round(each / spacing)
    signal = [rng.normal(0.0, 0.002, n // 2)]
    for mean, many in layers:
        shots = np.zeros(n + 200)
        for start in rng.integers(0, n, round(many * each)):
            shots[start:start + 60] += np.linspace(0.0, 1.0, 60)
        shots = shots[100:n + 100]
        signal.append(mean * shots / shots.mean())
    raw = np.clip(np.concatenate(signal) / 1e-3, -32000, 32000).astype(">i2")
    head = bytearray(512)
    struct.pack_into(">hi2f", head, 0, 4, len(raw), spacing, 1e-3)
    struct.pack_into(">6h", head, 20, 2026, 1, 28, 12, 0, 0)
    struct.pack_into(">2f", head, 264, 46.8, 9.8)
    struct.pack_into(">l", head, 358, len(raw))
    struct.pack_into(">h", head, 380, 45)
    return bytes(head) + raw.tobytes()


FORMATS = {"pit.xml": caaml(), "pit.pro": PRO, "pit.csv": CSV}


def write(folder, name="pit.xml", text=None):
    """Path of a profile written to a folder."""
    path = folder / name
    path.write_text(FORMATS[name] if text is None else text, encoding="utf-8")
    return path
