"""Draws setup.svg: where the symbols of model.md are measured. Usage: python3 setup.py"""

from math import cos, pi, radians, sin
from pathlib import Path

WIDTH, HEIGHT = 800, 590
AXIS_Y = 190  # of the principal ray
CAMERA_X, IMAGE_X, MIRROR_X, SHEET_X = 92, 250, 400, 660
ARM = MIRROR_X - IMAGE_X  # image and source are equally far from the half mirror
THETA = radians(25)
AZIMUTH = radians(35)

LIGHT = {
    "paper": "#ffffff",
    "ink": "#1c2733",
    "soft": "#5d6b7a",
    "ray": "#d1700c",
    "part": "#1769aa",
}
DARK = {
    "paper": "#10161d",
    "ink": "#e6edf3",
    "soft": "#9aa7b4",
    "ray": "#f2a245",
    "part": "#6cb6f5",
}
SHAPES = """
.ink, .soft, .ray, .part { fill: none; }
.ink { stroke-width: 1.5; }
.soft { stroke-width: 1; }
.ray { stroke-width: 1.4; }
.part { stroke-width: 4; }
.thin { stroke-width: 1.6; }
.dash { stroke-dasharray: 5 4; }
.face { fill-opacity: 0.15; stroke-width: 1.4; }
text, text.soft { stroke: none; font: 14px sans-serif; }
text.soft { font-size: 13px; }
text.middle { text-anchor: middle; }
text.end { text-anchor: end; }
text.symbol { font: italic 16px serif; }
"""


def colours(of):
    """Returns the rules of style that depend on the colours."""
    return f"""
.paper {{ fill: {of["paper"]}; }}
.ink {{ stroke: {of["ink"]}; }}
.soft {{ stroke: {of["soft"]}; }}
.ray {{ stroke: {of["ray"]}; }}
.part {{ stroke: {of["part"]}; }}
.face {{ fill: {of["part"]}; stroke: {of["part"]}; }}
.tip-ink, text {{ fill: {of["ink"]}; }}
.tip-ray {{ fill: {of["ray"]}; }}
text.soft {{ fill: {of["soft"]}; }}
"""


parts = []


def line(start, end, style):
    parts.append(
        f'<line class="{style}" x1="{start[0]:.1f}" y1="{start[1]:.1f}" '
        f'x2="{end[0]:.1f}" y2="{end[1]:.1f}"/>'
    )


def tip(end, direction, style="ink", size=9):
    """Draws an arrow head that ends at `end`."""
    length = (direction[0] ** 2 + direction[1] ** 2) ** 0.5
    x, y = direction[0] / length, direction[1] / length
    back = (end[0] - size * x, end[1] - size * y)
    corners = [
        end,
        (back[0] - 0.4 * size * y, back[1] + 0.4 * size * x),
        (back[0] + 0.4 * size * y, back[1] - 0.4 * size * x),
    ]
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in corners)
    parts.append(f'<polygon class="tip-{style}" points="{points}"/>')


def arrow(start, end, style="ink", both=False):
    way = (end[0] - start[0], end[1] - start[1])
    line(start, end, style)
    tip(end, way, style.split()[0])
    if both:
        tip(start, (-way[0], -way[1]), style.split()[0])


def text(x, y, words, style=""):
    parts.append(f'<text class="{style}" x="{x:.1f}" y="{y:.1f}">{words}</text>')


def dot(x, y, radius=3.2):
    parts.append(f'<circle class="tip-ink" cx="{x:.1f}" cy="{y:.1f}" r="{radius}"/>')


def arc(centre, radius, first, last):
    """Draws an arc between two angles, counter-clockwise on the page, in radians."""
    start = (centre[0] + radius * cos(first), centre[1] - radius * sin(first))
    end = (centre[0] + radius * cos(last), centre[1] - radius * sin(last))
    parts.append(
        f'<path class="ink" d="M {start[0]:.1f} {start[1]:.1f} '
        f'A {radius} {radius} 0 0 0 {end[0]:.1f} {end[1]:.1f}"/>'
    )


def rays():
    """Draws the light of one point of the source, there and back."""
    source, image = (MIRROR_X, AXIS_Y + ARM), (IMAGE_X, AXIS_Y)
    along = (sin(THETA), -cos(THETA))
    normal = (-cos(THETA), -sin(THETA))
    for slope in (-0.16, 0.0, 0.16):
        # The half mirror is the line x - MIRROR_X = AXIS_Y - y; the ray seems to come from the
        # image.
        t = ARM / (1 + slope)
        mirror = (image[0] + t, image[1] + slope * t)
        reach = (SHEET_X - IMAGE_X) * -normal[0]
        t = reach / -(normal[0] + slope * normal[1])
        sheet = (image[0] + t, image[1] + slope * t)
        line(source, mirror, "ray")
        line(mirror, sheet, "ray")
        line(image, mirror, "ray")
        lens = (CAMERA_X + 20, AXIS_Y - slope * (IMAGE_X - CAMERA_X - 20))
        line(image, lens, "ray")
        if slope:
            middle = (0.5 * (source[0] + mirror[0]), 0.5 * (source[1] + mirror[1]))
            tip(middle, (mirror[0] - source[0], mirror[1] - source[1]), "ray")
            at = (image[0] + 0.55 * t, image[1] + 0.55 * slope * t)
            tip(at, (1, slope), "ray")
            at = (image[0] + 0.82 * t, image[1] + 0.82 * slope * t)
            tip(at, (-1, -slope), "ray")
            at = (0.5 * (image[0] + lens[0]), 0.5 * (image[1] + lens[1]))
            tip(at, (-1, -slope), "ray")
    return along, normal


def setup():
    along, normal = rays()
    # The camera: a body and a lens.
    parts.append(
        f'<rect class="face" x="{CAMERA_X - 62}" y="{AXIS_Y - 30}" width="62" height="60" rx="6"/>'
    )
    parts.append(
        f'<rect class="face" x="{CAMERA_X}" y="{AXIS_Y - 22}" width="16" height="44" rx="4"/>'
    )
    text(CAMERA_X - 31, AXIS_Y + 52, "camera or", "middle")
    text(CAMERA_X - 31, AXIS_Y + 70, "viewer", "middle")
    # The half mirror.
    line((MIRROR_X - 62, AXIS_Y + 62), (MIRROR_X + 62, AXIS_Y - 62), "part thin")
    text(MIRROR_X + 56, AXIS_Y - 78, "half mirror", "middle")
    # The source.
    source_y = AXIS_Y + ARM
    line((MIRROR_X - 30, source_y), (MIRROR_X + 30, source_y), "part")
    text(MIRROR_X, source_y + 22, "source: a sign, or an edge to measure", "middle")
    text(MIRROR_X + 40, source_y - 30, "as far from the half mirror", "soft")
    text(MIRROR_X + 40, source_y - 13, "as the image is", "soft")
    # The sheet.
    centre = (SHEET_X, AXIS_Y)
    line(*[(centre[0] + k * along[0], centre[1] + k * along[1]) for k in (-84, 84)], "part")
    text(SHEET_X + 14, AXIS_Y + 60, "sheet of")
    text(SHEET_X + 14, AXIS_Y + 78, "corner cubes")
    foot = (SHEET_X + 118 * normal[0], AXIS_Y + 118 * normal[1])
    arrow(centre, foot)
    text(foot[0] - 4, foot[1] - 6, "n", "symbol end")
    arc(centre, 96, pi - THETA, pi)
    text(SHEET_X - 112, AXIS_Y - 18, "θ", "symbol middle")
    text(SHEET_X - 122, AXIS_Y - 18, "incidence", "soft end")
    end = (SHEET_X + 112 * along[0], AXIS_Y + 112 * along[1])
    arrow((SHEET_X + 86 * along[0], AXIS_Y + 86 * along[1]), end)
    text(end[0] + 8, end[1] + 10, "u", "symbol")
    cross = (SHEET_X + 78, AXIS_Y - 70)
    into_page(cross)
    text(cross[0] + 14, cross[1] + 5, "v", "symbol")
    # The image and its axes.
    arrow((IMAGE_X, AXIS_Y + 36), (IMAGE_X, AXIS_Y - 58))
    text(IMAGE_X - 8, AXIS_Y - 46, "x", "symbol end")
    text(IMAGE_X - 22, AXIS_Y - 46, "tangential", "soft end")
    into_page((IMAGE_X - 40, AXIS_Y + 58))
    text(IMAGE_X - 24, AXIS_Y + 63, "y", "symbol")
    text(IMAGE_X - 12, AXIS_Y + 63, "sagittal", "soft")
    text(IMAGE_X - 60, AXIS_Y + 84, "mid-air image", "middle")
    # Distances.
    for x, top in ((IMAGE_X, 38), (SHEET_X, 38), (MIRROR_X, 84)):
        line((x, top), (x, AXIS_Y - (62 if x == IMAGE_X else 8)), "soft dash")
    arrow((IMAGE_X, 46), (SHEET_X, 46), both=True)
    text(
        0.5 * (IMAGE_X + SHEET_X),
        36,
        "R: path from the sheet to the mid-air image",
        "middle",
    )
    arrow((IMAGE_X, 92), (MIRROR_X, 92), both=True)
    text(0.5 * (IMAGE_X + MIRROR_X), 82, "from the half mirror", "soft middle")


def into_page(at):
    parts.append(f'<circle class="ink" cx="{at[0]}" cy="{at[1]}" r="8"/>')
    for k in (-1, 1):
        line((at[0] - 5.5, at[1] - 5.5 * k), (at[0] + 5.5, at[1] + 5.5 * k), "ink")


def front_view():
    """Draws one aperture as the light sees it: first edge, azimuth, u, v, and a shift."""
    centre, size = (166, 480), 74
    corner = [
        (centre[0] + size * cos(2 * pi * k / 3), centre[1] - size * sin(2 * pi * k / 3))
        for k in range(3)
    ]
    points = " ".join(f"{x:.1f},{y:.1f}" for x, y in corner)
    parts.append(f'<polygon class="face" points="{points}"/>')
    for x, y in corner:
        line(centre, (x, y), "soft")
    first = (centre[0] + 118, centre[1])
    line(corner[0], first, "soft dash")
    text(first[0] + 6, first[1] + 5, "first edge: azimuth 0", "soft")
    u = (centre[0] + 104 * cos(AZIMUTH), centre[1] - 104 * sin(AZIMUTH))
    v = (centre[0] - 84 * sin(AZIMUTH), centre[1] - 84 * cos(AZIMUTH))
    arrow(centre, u)
    arrow(centre, v)
    text(u[0] + 8, u[1] + 2, "u", "symbol")
    text(v[0] - 8, v[1] + 2, "v", "symbol end")
    arc(centre, 58, 0, AZIMUTH)
    text(centre[0] + 70, centre[1] - 14, "φ", "symbol")
    text(300, 408, "The sheet from the light's side (n towards you):")
    words = [
        "u is the direction of the arriving light, seen within the sheet;",
        "φ (azimuth) is its angle from the first edge of the first cube,",
        "counter-clockwise. v = n × u.",
    ]
    for k, sentence in enumerate(words):
        text(300, 430 + 18 * k, sentence, "soft")
    text(360, 524, "A ray enters at p and leaves at p′, opposite to q.", "soft")
    text(360, 542, "Its shift p′ − p is measured along u and v,", "soft")
    text(360, 560, "in edge lengths of the cube.", "soft")
    # q lies on the line from the apex along -u; p and p' lie on opposite sides of it.
    q = (centre[0] - 20 * cos(AZIMUTH), centre[1] + 20 * sin(AZIMUTH))
    start = (q[0] - 4, q[1] + 22)
    end = (2 * q[0] - start[0], 2 * q[1] - start[1])
    line(start, end, "ray")
    tip(end, (end[0] - start[0], end[1] - start[1]), "ray")
    dot(*start)
    dot(*end)
    dot(*q, radius=2.2)
    text(q[0] + 8, q[1] + 12, "q", "symbol")
    text(start[0] - 8, start[1] + 10, "p", "symbol end")
    text(end[0] - 8, end[1] - 4, "p′", "symbol end")


def main():
    setup()
    front_view()
    label = (
        "Setup: light of the source is reflected by the half mirror to the sheet, comes back "
        "displaced, passes the half mirror and forms the mid-air image before the camera."
    )
    body = "\n".join(parts)
    dark = f"@media (prefers-color-scheme: dark) {{{colours(DARK)}}}"
    style = SHAPES + colours(LIGHT) + dark + "\n"
    Path(__file__).with_name("setup.svg").write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" '
        f'aria-label="{label}">\n<title>{label}</title>\n<style>{style}</style>\n'
        f'<rect class="paper" width="{WIDTH}" height="{HEIGHT}" rx="10"/>\n{body}\n</svg>\n'
    )


if __name__ == "__main__":
    main()
