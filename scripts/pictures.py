# SPDX-License-Identifier: MIT
"""Pictures of meshes for the documentation: cut open, elements colored by layer and by R/3r.

    xvfb-run -a /usr/bin/python3 scripts/pictures.py PROGRAM DATA [FOLDER, default docs/images]

Meshes the slice files of PICTURES that are found in DATA/reference or DATA with the program, reads the VTU file it writes, and
renders two PNG files of each. Needs python3-vtk9, python3-numpy, python3-pil and a display (xvfb).
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


def render(surface, colors, direction, legend, path):
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputData(surface)
    mapper.SetLookupTable(lookup_table(colors))
    mapper.SetUseLookupTableScalarRange(True)
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    look = actor.GetProperty()
    look.SetInterpolationToFlat()
    look.SetAmbient(0.5)
    look.SetDiffuse(0.52)
    look.SetEdgeVisibility(True)
    look.SetEdgeColor(0.15, 0.15, 0.15)
    look.SetLineWidth(1.2)
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    renderer.AddActor(actor)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetMultiSamples(8)
    window.SetSize(FINER * WIDTH, FINER * HEIGHT)
    window.AddRenderer(renderer)

    # Parallel projection; the part fills what the legend leaves free.
    direction = numpy.asarray(direction, float) / numpy.linalg.norm(direction)
    right = numpy.cross((0, 0, 1), direction)
    right /= numpy.linalg.norm(right)
    up = numpy.cross(direction, right)
    points = vtk_to_numpy(surface.GetPoints().GetData()).astype(float)
    spans = [(points @ axis).min() for axis in (right, up, direction)], [(points @ axis).max() for axis in (right, up, direction)]
    middle = [(low + high) / 2 for low, high in zip(*spans)]
    size = [high - low for low, high in zip(*spans)]
    free = (20, 20, WIDTH - 225, HEIGHT - 80)  # pixels: left, bottom, right, top
    pixel = max(size[0] / (free[2] - free[0]), size[1] / (free[3] - free[1]))  # mm
    # The center of the window lies beside that of the free room.
    shift = [(WIDTH / 2 - (free[0] + free[2]) / 2) * pixel, (HEIGHT / 2 - (free[1] + free[3]) / 2) * pixel]
    focus = (middle[0] + shift[0]) * right + (middle[1] + shift[1]) * up + middle[2] * direction
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    camera.SetParallelScale(HEIGHT / 2 * pixel)
    camera.SetFocalPoint(*focus)
    camera.SetPosition(*(focus + 10 * max(size) * direction))
    camera.SetViewUp(0, 0, 1)
    legend(renderer)
    renderer.ResetCameraClippingRange()
    window.Render()

    picture = vtk.vtkWindowToImageFilter()
    picture.SetInput(window)
    picture.ReadFrontBufferOff()
    picture.Update()
    image = picture.GetOutput()
    pixels = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(FINER * HEIGHT, FINER * WIDTH, 3)[::-1]
    small = Image.fromarray(numpy.ascontiguousarray(pixels)).resize((WIDTH, HEIGHT), Image.BOX)
    # Files with a palette are a third as large. It holds shades of the colors of the legend, so that no rare color is lost or invented.
    bases = colors[:: math.ceil(len(colors) / 20)]
    shades = 216 // len(bases)
    palette = [tuple((0.15 + 0.85 * (i + 1) / shades) * c for c in base) for base in bases for i in range(shades)]
    palette += [(i / 39,) * 3 for i in range(40)]
    holder = Image.new("P", (1, 1))
    holder.putpalette([min(255, round(255 * c)) for color in palette for c in color])
    small.quantize(palette=holder, dither=Image.Dither.NONE).save(path, optimize=True)


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


def find(data, name):
    for folder in (os.path.join(data, "reference"), data):
        for file in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
            if file.startswith(name) and file.endswith(".cli"):
                return os.path.join(folder, file)
    return None


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    program, data = sys.argv[1:3]
    here = os.path.dirname(os.path.abspath(__file__))
    folder = sys.argv[3] if len(sys.argv) == 4 else os.path.join(here, "..", "docs", "images")
    os.makedirs(folder, exist_ok=True)
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
