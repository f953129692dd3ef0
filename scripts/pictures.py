# SPDX-License-Identifier: MIT
"""Pictures of meshes for the documentation: cut open, elements colored by layer and by R/3r.

    xvfb-run -a -w 10 /usr/bin/python3 scripts/pictures.py PROGRAM DATA [FOLDER, default docs/images]
    xvfb-run -a -w 10 /usr/bin/python3 scripts/pictures.py PROGRAM EXAMPLES --stages [FOLDER]

The first meshes the slice files of PICTURES that are found in DATA/reference or DATA with the program, reads the VTU file it writes,
and renders two PNG files of each. The second makes the pictures of the stages from the sample part: slices, complex and meshes,
before and after improvement, in 3D, and the overview of the README; EXAMPLES is the folder with make_sample and slices_svg, which
draws the picture of contours and interface. Needs python3-vtk9, python3-numpy, python3-pil and a display (xvfb).
"""
import math
import os
import subprocess
import sys
import tempfile

import numpy
import vtk
from PIL import Image
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

WIDTH, HEIGHT = 900, 700  # pixels
FINER = 2  # rendered with so many times the pixels each way, then averaged: thin edges

# File, what to call it, cuts (normal, place as a share of the extent along it; what lies beyond all of them is taken away), direction
# from which to look.
PICTURES = [
    ("T_supported", "T with supports", [((0, -1, 0), 0.5)], (0.3, -1, 0.22)),
    ("joint", "joint", [((0, -1, 0), 0.5)], (0.45, -1, 0.6)),
    ("sphere", "sphere", [((0, -1, 0), 0.5), ((1, 0, 0), 0.5)], (0.7, -1, 0.65)),
]

# Upper ends of the bands of R/3r and their colors: blues are good, red is bad.
BANDS = [
    (1.25, (49, 104, 163)),
    (1.5, (103, 160, 203)),
    (2.0, (187, 217, 233)),
    (3.0, (250, 236, 188)),
    (5.0, (251, 190, 112)),
    (8.0, (237, 120, 66)),
    (math.inf, (178, 20, 40)),
]


def radius_ratios(points, tets):
    """#T values of R/3r from #P by 3 coordinates and #T by 4 indices."""
    p = points[tets[:, 0]]
    a, b, c = (points[tets[:, i]] - p for i in (1, 2, 3))
    ab, bc, ca = numpy.cross(a, b), numpy.cross(b, c), numpy.cross(c, a)
    six_volumes = numpy.abs(numpy.einsum("ij,ij->i", a, bc))
    squares = [numpy.einsum("ij,ij->i", v, v)[:, None] for v in (a, b, c)]
    radius = numpy.linalg.norm(squares[0] * bc + squares[1] * ca + squares[2] * ab, axis=1) / (2 * six_volumes)
    double_areas = sum(numpy.linalg.norm(n, axis=1) for n in (ab, bc, ca, ab + bc + ca))
    return radius * double_areas / (3 * six_volumes)


def layer_color(layer, layers):
    """From blue over green to yellow, every second layer darker, so that each one can be told from its neighbours."""
    stops = [(68, 84, 160), (45, 140, 160), (80, 175, 120), (170, 205, 90), (245, 215, 80)]
    x = (len(stops) - 1) * layer / max(1, layers - 1)
    i = min(int(x), len(stops) - 2)
    shade = 1.0 if layer % 2 == 0 else 0.80
    return tuple(shade * (stops[i][k] + (x - i) * (stops[i + 1][k] - stops[i][k])) / 255 for k in range(3))


def lookup_table(colors):
    table = vtk.vtkLookupTable()
    table.SetNumberOfTableValues(len(colors))
    table.SetTableRange(-0.5, len(colors) - 0.5)
    for i, color in enumerate(colors):
        table.SetTableValue(i, *color, 1.0)
    return table


def text(renderer, words, x, y, size, bold=False):
    actor = vtk.vtkTextActor()
    actor.SetInput(words)
    actor.SetPosition(FINER * x, FINER * y)
    style = actor.GetTextProperty()
    style.SetFontFamilyToArial()
    style.SetFontSize(FINER * size)
    style.SetBold(bold)
    style.SetColor(0.1, 0.1, 0.1)
    renderer.AddActor2D(actor)


def swatch(renderer, x, y, width, height, color):
    points = vtk.vtkPoints()
    for corner in ((x, y), (x + width, y), (x + width, y + height), (x, y + height)):
        points.InsertNextPoint(FINER * corner[0], FINER * corner[1], 0)
    cells = vtk.vtkCellArray()
    cells.InsertNextCell(4)
    for i in range(4):
        cells.InsertCellPoint(i)
    area = vtk.vtkPolyData()
    area.SetPoints(points)
    area.SetPolys(cells)
    mapper = vtk.vtkPolyDataMapper2D()
    mapper.SetInputData(area)
    actor = vtk.vtkActor2D()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*color)
    renderer.AddActor2D(actor)


class Part:
    def __init__(self, path):
        reader = vtk.vtkXMLUnstructuredGridReader()
        reader.SetFileName(path)
        reader.Update()
        self.grid = reader.GetOutput()
        self.points = vtk_to_numpy(self.grid.GetPoints().GetData())
        self.tets = vtk_to_numpy(self.grid.GetCells().GetConnectivityArray()).reshape(-1, 4)
        self.layer = vtk_to_numpy(self.grid.GetCellData().GetArray("layer"))
        self.ratio = radius_ratios(self.points, self.tets)

    def cut(self, cuts, values):
        """Surface of what the cuts leave, in whole tets, with one value per cell."""
        beyond = numpy.ones(len(self.tets), bool)
        for normal, place in cuts:
            heights = self.points @ (numpy.asarray(normal, float) / numpy.linalg.norm(normal))
            beyond &= heights[self.tets].mean(axis=1) > heights.min() + place * (heights.max() - heights.min())
        keep = numpy.flatnonzero(~beyond)
        ids = numpy_to_vtk(keep.astype(numpy.int64), deep=True, array_type=vtk.VTK_ID_TYPE)
        node = vtk.vtkSelectionNode()
        node.SetFieldType(vtk.vtkSelectionNode.CELL)
        node.SetContentType(vtk.vtkSelectionNode.INDICES)
        node.SetSelectionList(ids)
        selection = vtk.vtkSelection()
        selection.AddNode(node)
        grid = vtk.vtkUnstructuredGrid()
        grid.ShallowCopy(self.grid)
        array = numpy_to_vtk(numpy.ascontiguousarray(values, dtype=float), deep=True)
        array.SetName("value")
        grid.GetCellData().SetScalars(array)
        extract = vtk.vtkExtractSelection()
        extract.SetInputData(0, grid)
        extract.SetInputData(1, selection)
        surface = vtk.vtkGeometryFilter()
        surface.SetInputConnection(extract.GetOutputPort())
        surface.Update()
        return surface.GetOutput()


def actor_of(data, colors, edges=True, width=1.2):
    """What is drawn of a surface or of lines with the scalar "value", an index of `colors`."""
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputData(data)
    mapper.SetLookupTable(lookup_table(colors))
    mapper.SetUseLookupTableScalarRange(True)
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    look = actor.GetProperty()
    look.SetInterpolationToFlat()
    look.SetAmbient(0.5 if edges else 1.0)
    look.SetDiffuse(0.52 if edges else 0.0)
    look.SetEdgeVisibility(edges)
    look.SetEdgeColor(0.15, 0.15, 0.15)
    look.SetLineWidth(width)
    return actor


def shot(actors, points, direction, size, free, legend):
    """An RGB image of `size` pixels: parallel projection, with the points filling `free` (left, bottom, right, top)."""
    width, height = size
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    for actor in actors:
        renderer.AddActor(actor)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetMultiSamples(8)
    window.SetSize(FINER * width, FINER * height)
    window.AddRenderer(renderer)

    direction = numpy.asarray(direction, float) / numpy.linalg.norm(direction)
    right = numpy.cross((0, 0, 1), direction)
    right /= numpy.linalg.norm(right)
    up = numpy.cross(direction, right)
    spans = [(points @ axis).min() for axis in (right, up, direction)], [(points @ axis).max() for axis in (right, up, direction)]
    middle = [(low + high) / 2 for low, high in zip(*spans)]
    extent = [high - low for low, high in zip(*spans)]
    pixel = max(extent[0] / (free[2] - free[0]), extent[1] / (free[3] - free[1]))  # mm
    # The center of the window lies beside that of the free room.
    shift = [(width / 2 - (free[0] + free[2]) / 2) * pixel, (height / 2 - (free[1] + free[3]) / 2) * pixel]
    focus = (middle[0] + shift[0]) * right + (middle[1] + shift[1]) * up + middle[2] * direction
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    camera.SetParallelScale(height / 2 * pixel)
    camera.SetFocalPoint(*focus)
    camera.SetPosition(*(focus + 10 * max(extent) * direction))
    camera.SetViewUp(0, 0, 1)
    legend(renderer)
    renderer.ResetCameraClippingRange()
    window.Render()

    picture = vtk.vtkWindowToImageFilter()
    picture.SetInput(window)
    picture.ReadFrontBufferOff()
    picture.Update()
    image = picture.GetOutput()
    pixels = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(FINER * height, FINER * width, 3)[::-1]
    return Image.fromarray(numpy.ascontiguousarray(pixels)).resize((width, height), Image.BOX)


def save(image, colors, path):
    # Files with a palette are a third as large. It holds shades of the colors of the legend, so that no rare color is lost or invented.
    bases = colors[:: math.ceil(len(colors) / 20)]
    shades = 216 // len(bases)
    palette = [tuple((0.15 + 0.85 * (i + 1) / shades) * c for c in base) for base in bases for i in range(shades)]
    palette += [(i / 39,) * 3 for i in range(40)]
    holder = Image.new("P", (1, 1))
    holder.putpalette([min(255, round(255 * c)) for color in palette for c in color])
    image.quantize(palette=holder, dither=Image.Dither.NONE).save(path, optimize=True)


def render(surface, colors, direction, legend, path):
    points = vtk_to_numpy(surface.GetPoints().GetData()).astype(float)
    # The part fills what the legend leaves free.
    free = (20, 20, WIDTH - 225, HEIGHT - 80)
    save(shot([actor_of(surface, colors)], points, direction, (WIDTH, HEIGHT), free, legend), colors, path)


def band_of(ratios):
    return numpy.searchsorted([end for end, _ in BANDS], ratios, side="left")


def layer_legend(part, name):
    layers = int(part.layer.max()) + 1

    def draw(renderer):
        left, low, high = WIDTH - 190, 120, HEIGHT - 130
        text(renderer, name, 24, HEIGHT - 44, 22, True)
        text(renderer, "{:,} tets, each in one of {} layers".format(len(part.tets), layers), 24, HEIGHT - 70, 16)
        text(renderer, "layer", left, high + 18, 18, True)
        step = (high - low) / layers
        every = next(n for n in (1, 2, 5, 10, 20, 50, 100) if n * step >= 24)
        for i in range(layers):
            swatch(renderer, left, low + i * step, 40, step, layer_color(i, layers))
            if i == 0 or ((i + 1) % every == 0 and i * step >= 18):
                text(renderer, str(i + 1), left + 50, low + (i + 0.5) * step - 7, 15)

    return draw


def ratio_legend(part, name):
    bands = band_of(part.ratio)

    def draw(renderer):
        left, high = WIDTH - 190, HEIGHT - 130
        text(renderer, name, 24, HEIGHT - 44, 22, True)
        text(renderer, "{:,} tets, R/3r: mean {:.2f}, worst {:.1f}".format(len(part.tets), part.ratio.mean(), part.ratio.max()), 24,
             HEIGHT - 70, 16)
        text(renderer, "R/3r", left, high + 18, 18, True)
        text(renderer, "share of tets", left + 62, high + 19, 13)
        start = 1.0
        for i, (end, color) in enumerate(BANDS):
            y = high - 34 * (i + 1)
            swatch(renderer, left, y, 26, 26, tuple(c / 255 for c in color))
            text(renderer, "%g-%g" % (start, end) if math.isfinite(end) else "> %g" % start, left + 36, y + 6, 15)
            share = 100 * numpy.count_nonzero(bands == i) / len(bands)
            text(renderer, "0" if share == 0 else "%.1f %%" % share if share >= 1 else "%.2g %%" % share, left + 112, y + 6, 15)
            start = end

    return draw


# --- the stages, of the sample part ------------------------------------------------------------------------------------
LOOK = (0.5, -1, 0.55)
PANEL = (420, 330)  # pixels
SLICE_COLORS = [(0.12, 0.35, 0.62), (0.80, 0.25, 0.15)]  # contours, support lines
LABELS = [("facing down", (0.96, 0.60, 0.45)), ("facing up", (0.45, 0.70, 0.88)), ("interface", (0.86, 0.86, 0.86)),
          ("wall", (0.70, 0.80, 0.62)), ("wall between regions", (0.80, 0.70, 0.85))]


def poly_data(points, cells, values, lines):
    data = vtk.vtkPolyData()
    places = vtk.vtkPoints()
    places.SetData(numpy_to_vtk(numpy.ascontiguousarray(points, dtype=float), deep=True))
    data.SetPoints(places)
    array = vtk.vtkCellArray()
    for cell in cells:
        array.InsertNextCell(len(cell))
        for corner in cell:
            array.InsertCellPoint(int(corner))
    (data.SetLines if lines else data.SetPolys)(array)
    scalars = numpy_to_vtk(numpy.ascontiguousarray(values, dtype=float), deep=True)
    scalars.SetName("value")
    data.GetCellData().SetScalars(scalars)
    return data


def read_slices(path):
    """Points (mm), lines, and for each whether it is open, of a CLI file written as text by make_sample."""
    points, lines, is_open = [], [], []
    unit, z = 1.0, 0.0
    with open(path, encoding="ascii") as file:
        for line in file:
            command, _, rest = line.strip().partition("/")
            if command == "$$UNITS":
                unit = float(rest)
            elif command == "$$LAYER":
                z = float(rest) * unit
            elif command == "$$POLYLINE":
                numbers = rest.split(",")
                places = numpy.array(numbers[3:], float).reshape(-1, 2) * unit
                first = len(points)
                points += [(x, y, z) for x, y in places]
                cell = list(range(first, len(points)))
                is_open.append(int(numbers[1]) == 2)
                lines.append(cell if is_open[-1] else cell + [first])
    return numpy.array(points), lines, numpy.array(is_open)


def read_complex(path):
    """Points, triangles and labels of a complex written as PLY."""
    with open(path, "rb") as file:
        text = file.read()
    end = text.index(b"end_header\n") + len(b"end_header\n")
    counts = [int(line.split()[2]) for line in text[:end].decode("ascii").splitlines() if line.startswith("element")]
    points = numpy.frombuffer(text, "<f8", 3 * counts[0], end).reshape(-1, 3)
    face = numpy.dtype([("n", "u1"), ("v", "<i4", 3), ("label", "u1"), ("sides", "<i4", 4)])
    faces = numpy.frombuffer(text, face, counts[1], end + points.nbytes)
    return points, faces["v"], faces["label"]


def nothing(_):
    pass


def captions(words, height):
    """Draws the words of a legend with their colors, from the top."""

    def draw(renderer):
        for i, (word, color) in enumerate(words):
            swatch(renderer, 14, height - 56 - 22 * i, 14, 14, color)
            text(renderer, word, 36, height - 55 - 22 * i, 14)

    return draw


def titled(title, more=nothing, height=PANEL[1]):
    def draw(renderer):
        text(renderer, title, 14, height - 28, 17, True)
        more(renderer)

    return draw


def stages(program, examples, folder):
    with tempfile.TemporaryDirectory() as work:
        def file(name):
            return os.path.join(work, name)

        def run(*command):
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)

        sample = file("sample.cli")
        run(os.path.join(examples, "make_sample"), sample)
        run(os.path.join(examples, "slices_svg"), sample, os.path.join(folder, "stage_contours.svg"))
        options = ["--quiet", sample, "--support-radius", "0.1", "--lump", "2"]
        run(program, *options, "-o", file("raw.vtu"), "--improve-rounds", "0")
        run(program, *options, "-o", file("mesh.vtu"), "--plc", file("complex.ply"))
        raw, part = Part(file("raw.vtu")), Part(file("mesh.vtu"))
        slice_points, lines, is_open = read_slices(sample)
        points, triangles, labels = read_complex(file("complex.ply"))

    cut = [((0, -1, 0), 0.45)]
    layers = int(part.layer.max()) + 1
    layer_colors = [layer_color(i, layers) for i in range(layers)]
    band_colors = [tuple(c / 255 for c in color) for _, color in BANDS]
    label_colors = [color for _, color in LABELS]
    slices = actor_of(poly_data(slice_points, lines, is_open.astype(float), True), SLICE_COLORS, False, 2.0)
    # The complex is opened too: the front is taken away, so that interfaces show.
    front = points[triangles].mean(axis=1)[:, 1]
    kept = front > points[:, 1].min() + 0.55 * (points[:, 1].max() - points[:, 1].min())
    surface = actor_of(poly_data(points, triangles[kept], labels[kept], False), label_colors, True, 0.7)
    mesh = actor_of(part.cut(cut, part.layer), layer_colors, True, 0.7)

    free = (14, 14, PANEL[0] - 14, PANEL[1] - 44)
    width, height = PANEL
    panels = [
        shot([slices], part.points, LOOK, PANEL, free, titled("1  slices")),
        shot([surface], part.points, LOOK, PANEL, free, titled("2  complex, opened")),
        shot([mesh], part.points, LOOK, PANEL, free, titled("3  mesh, opened: one color per layer")),
    ]
    overview = Image.new("RGB", (3 * width, height), "white")
    for i, panel in enumerate(panels):
        overview.paste(panel, (i * width, 0))
    save(overview, layer_colors[::2] + label_colors + SLICE_COLORS, os.path.join(folder, "overview.png"))

    big = (760, 420)
    free = (180, 14, big[0] - 14, big[1] - 44)

    def stage(name, title, actor, words, colors, shown=points[points[:, 1] > 0.5 * points[:, 1].max()]):
        image = shot([actor], shown, LOOK, big, free, titled(title, captions(words, big[1]), big[1]))
        save(image, colors, os.path.join(folder, "stage_%s.png" % name))

    stage("slices", "Slices", slices, list(zip(("contour", "support line"), SLICE_COLORS)), SLICE_COLORS, part.points)
    seen = [entry for i, entry in enumerate(LABELS) if (labels[kept] == i).any()]
    stage("complex", "Complex, opened", surface, seen, label_colors)
    for name, which, title in (("fill", raw, "Filled"), ("improve", part, "Improved")):
        bands = band_of(which.ratio)
        words, start = [], 1.0
        for i, (end, _) in enumerate(BANDS):
            share = 100 * numpy.count_nonzero(bands == i) / len(bands)
            words.append((("%g-%g" % (start, end) if math.isfinite(end) else "> %g" % start) + ": %.2g %%" % share, band_colors[i]))
            start = end
        heading = "%s: %s tets, R/3r mean %.2f, worst %.3g" % (title, "{:,}".format(len(which.tets)), which.ratio.mean(), which.ratio.max())
        stage(name, heading, actor_of(which.cut(cut, bands), band_colors, True, 0.7), words, band_colors)
    print("6 pictures in %s" % os.path.normpath(folder))


def find(data, name):
    for folder in (os.path.join(data, "reference"), data):
        for file in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
            if file.startswith(name) and file.endswith(".cli"):
                return os.path.join(folder, file)
    return None


def main():
    arguments = [argument for argument in sys.argv[1:] if argument != "--stages"]
    if len(arguments) not in (2, 3):
        sys.exit(__doc__)
    program, data = arguments[:2]
    here = os.path.dirname(os.path.abspath(__file__))
    folder = arguments[2] if len(arguments) == 3 else os.path.join(here, "..", "docs", "images")
    os.makedirs(folder, exist_ok=True)
    if "--stages" in sys.argv:
        return stages(program, data, folder)
    made = 0
    for stem, title, cuts, direction in PICTURES:
        source = find(data, stem)
        if source is None:
            print("not in %s: %s" % (data, stem), file=sys.stderr)
            continue
        with tempfile.TemporaryDirectory() as work:
            mesh = os.path.join(work, "mesh.vtu")
            subprocess.run([program, "--quiet", source, "-o", mesh, "--support-radius", "0.1"], check=True, stdout=subprocess.DEVNULL)
            part = Part(mesh)
        layers = int(part.layer.max()) + 1
        name = stem.lower()
        surface = part.cut(cuts, part.layer)
        render(surface, [layer_color(i, layers) for i in range(layers)], direction, layer_legend(part, title),
               os.path.join(folder, name + "_layers.png"))
        surface = part.cut(cuts, band_of(part.ratio))
        render(surface, [tuple(c / 255 for c in color) for _, color in BANDS], direction, ratio_legend(part, title),
               os.path.join(folder, name + "_ratio.png"))
        made += 2
    print("%d pictures in %s" % (made, os.path.normpath(folder)))
    if made == 0:
        sys.exit(1)


if __name__ == "__main__":
    main()
