"""Layers of the project as files that snowmpm reads: in one projection in metres, without what QGIS alone has."""

import os

from osgeo import gdal
from qgis.core import (
    QgsCoordinateReferenceSystem,
    QgsCoordinateTransform,
    QgsFeature,
    QgsFeatureRequest,
    QgsFeatureSink,
    QgsField,
    QgsFields,
    QgsProcessingException,
    QgsProject,
    QgsRasterFileWriter,
    QgsRasterPipe,
    QgsRectangle,
    QgsUnitTypes,
    QgsVectorFileWriter,
    QgsWkbTypes,
)
from qgis.PyQt.QtCore import QVariant

from .words import tr

gdal.UseExceptions()
NO_DATA = -9999.0
WORLD = QgsRectangle(-360.0, -180.0, 360.0, 180.0)
"""Degrees."""


def system_of(crs):
    """A system as it is; an invalid one for that of a scene without a projection, whose coordinates have no place."""
    return QgsCoordinateReferenceSystem() if crs.toWkt().startswith(("LOCAL_CS", "ENGCRS")) else crs


def _beside(path):
    """A file beside that of an earlier run, which may be the source of the new one."""
    stem, ending = os.path.splitext(path)
    remove(f"{stem}.new{ending}")
    return f"{stem}.new{ending}"


def _put(new, path):
    """Put a new file in the place of an earlier one."""
    remove(path)
    os.replace(new, path)


def remove(path):
    """Remove a file, and what SQLite and GDAL left beside it."""
    for file in (path, path + "-wal", path + "-shm", path + ".aux.xml"):
        if os.path.exists(file):
            os.remove(file)


def metric_system(layer):
    """A system in metres for a raster layer: its own, that of the project, or the UTM zone of its middle; an invalid
    one where the layer names none."""
    own = system_of(layer.crs())
    if not own.isValid() or _in_metres(own):
        return own
    project = QgsProject.instance().crs()
    if project.isValid() and _in_metres(project):
        return project
    world = QgsCoordinateReferenceSystem("EPSG:4326")
    middle = QgsCoordinateTransform(own, world, QgsProject.instance()).transform(layer.extent().center())
    zone = min(60, max(1, int((middle.x() + 180.0) // 6.0) + 1))
    return QgsCoordinateReferenceSystem(f"EPSG:{32600 + zone if middle.y() >= 0.0 else 32700 + zone}")


def _in_metres(crs):
    """Whether a metre of it is one on the ground, near enough: that of web maps is 0.7 m in the Alps."""
    metres = crs.mapUnits() == QgsUnitTypes.DistanceUnit.DistanceMeters
    return metres and not crs.isGeographic() and crs.projectionAcronym() != "merc"


def write_raster(layer, path, crs, feedback, extent=None):
    """Write band 1 of a raster layer as a GeoTIFF of float32 in a system in metres; -> the path.

    extent: part of it, in the coordinates of `crs`, or None. Raises QgsProcessingException.
    """
    if layer is None or not layer.isValid():
        raise QgsProcessingException(tr("The elevation model is no raster that can be read."))
    source, scratch, new = layer.source().split("|")[0], None, _beside(path)
    if layer.providerType() != "gdal":
        source = scratch = path + ".source.tif"
        _copy_of_service(layer, source)
    box = [extent.xMinimum(), extent.yMinimum(), extent.xMaximum(), extent.yMaximum()] if extent else None
    own = system_of(layer.crs())
    options = {"format": "GTiff", "outputType": gdal.GDT_Float32, "creationOptions": ["COMPRESS=DEFLATE"]}
    try:
        opened = gdal.Open(source)
        if own.isValid() and own != crs:
            feedback.pushInfo(tr("The elevation model is brought from {} to {}.").format(_named(own), _named(crs)))
            gdal.Warp(new, opened, srcSRS=own.toWkt(), dstSRS=crs.toWkt(), resampleAlg="bilinear", outputBounds=box,
                      dstNodata=NO_DATA, **options)
        else:
            if box:
                options["projWin"] = [box[0], box[3], box[2], box[1]]
            named = own.toWkt() if own.isValid() else None
            made = gdal.Translate(new, opened, bandList=[1], outputSRS=named, **options)
            if not own.isValid():
                made.SetProjection("")
            made = None  # closes the file
        opened = None
    except RuntimeError as error:
        raise QgsProcessingException(tr("The elevation model could not be copied: {}").format(error)) from error
    finally:
        if scratch and os.path.exists(scratch):
            os.remove(scratch)
    _put(new, path)
    return path


def _copy_of_service(layer, path):
    """Write a raster that is no file, such as one of a WCS, at its own resolution."""
    pipe, provider, extent = QgsRasterPipe(), layer.dataProvider(), layer.extent()
    pipe.set(provider.clone())
    columns, rows = provider.xSize() or 1000, provider.ySize() or 1000
    code = QgsRasterFileWriter(path).writeRaster(pipe, columns, rows, extent, layer.crs(),
                                                 QgsProject.instance().transformContext())
    if code != QgsRasterFileWriter.WriterError.NoError:
        raise QgsProcessingException(tr("The elevation model could not be read from its service."))


def _named(crs):
    return crs.authid() or crs.description()


def write_features(source, path, context, feedback, crs=None, numbers=None, texts=None, keep=None):
    """Write the features of a feature source to a new GeoPackage; -> how many.

    crs: of the file, by default that of the source; where either is invalid, coordinates stay as they are. numbers,
    texts: {attribute of the file: name of the source's field, or a value, or (name, value where it is null)}; keep:
    takes a feature, and says whether it is written. Features without geometry are left out.
    """
    new = _beside(path)
    for name in [*(numbers or {}).values(), *(texts or {}).values()]:
        require_field(source, name[0] if isinstance(name, tuple) else name)
    fields = QgsFields()
    for name in numbers or {}:
        fields.append(QgsField(name, QVariant.Double))
    for name in texts or {}:
        fields.append(QgsField(name, QVariant.String))
    own, project = system_of(source.sourceCrs()), context.transformContext()
    if own.isGeographic() and not WORLD.contains(source.sourceExtent()):
        feedback.pushWarning(tr("{}: its coordinates are no degrees, although it is in {}: they are taken as those of"
                                " the terrain").format(source.sourceName(), _named(own)))
        own = QgsCoordinateReferenceSystem()
    crs = own if crs is None else crs
    change = QgsCoordinateTransform(own, crs, project) if own.isValid() and crs.isValid() and own != crs else None
    options = QgsVectorFileWriter.SaveVectorOptions()
    options.driverName, options.layerName = "GPKG", "features"
    options.datasourceOptions = ["VERSION=1.3"]
    kind = QgsWkbTypes.multiType(QgsWkbTypes.flatType(source.wkbType()))
    writer = QgsVectorFileWriter.create(new, fields, kind, crs if crs.isValid() else own, project, options)
    if writer.hasError() != QgsVectorFileWriter.WriterError.NoError:
        raise QgsProcessingException(writer.errorMessage())
    count = 0
    for feature in source.getFeatures(QgsFeatureRequest()):
        if not feature.hasGeometry() or feature.geometry().isEmpty() or (keep and not keep(feature)):
            continue
        geometry = feature.geometry()
        if change:
            geometry.transform(change)
        if not geometry.isMultipart():
            geometry.convertToMultiType()
        abstract = geometry.get()
        abstract.dropZValue()
        abstract.dropMValue()
        written = QgsFeature(fields)
        written.setGeometry(geometry)
        written.setAttributes([value_of(feature, field, float) for field in (numbers or {}).values()]
                              + [value_of(feature, field, str) for field in (texts or {}).values()])
        writer.addFeature(written, QgsFeatureSink.Flag.FastInsert)
        count += 1
    del writer  # closes the file
    if count:
        _put(new, path)
    else:
        remove(new)
    return count


def require_field(source, name):
    """Raise QgsProcessingException for the name of a field that the source does not have; numbers are none."""
    if isinstance(name, str) and name and source.fields().lookupField(name) < 0:
        raise QgsProcessingException(tr("{} has no attribute {}").format(source.sourceName(), name))


def value_of(feature, field, kind):
    """Value of a field of a feature, None where it is null; or the value itself, where it is no name of a field; of
    (field, value) the value where there is no such field or it is null."""
    if isinstance(field, tuple):
        own = value_of(feature, field[0], kind) if field[0] else None
        return field[1] if own is None else own
    value = feature[field] if isinstance(field, str) else field
    if value is None or value == QVariant() or str(value) == "NULL":
        return None
    try:
        return kind(value)
    except (TypeError, ValueError) as error:
        raise QgsProcessingException(tr("Feature {}: {} = {} is no number").format(feature.id(), field, value)) \
            from error


def values_of(source, field):
    """Values of a field as text, in the order of the features, each once."""
    require_field(source, field)
    found = {}
    for feature in source.getFeatures(QgsFeatureRequest()):
        text = value_of(feature, field, str)
        if feature.hasGeometry() and text:
            found[text] = None
    return list(found)
