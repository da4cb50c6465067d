// SPDX-License-Identifier: Apache-2.0
#include "interaction_outcome.h"

#include <gtest/gtest.h>

#include <QJsonArray>
#include <QJsonDocument>
#include <vector>

#include "session/scene.h"
#include "session/session.h"

namespace simplexseg {
namespace {

/// Compares displays; the free plane follows the mouse to a pixel.
void expect_similar_display(QJsonObject got, QJsonObject expected) {
  const QJsonObject plane = got.take("free_plane").toObject(), recorded = expected.take("free_plane").toObject();
  EXPECT_EQ(got, expected) << QJsonDocument(got).toJson().toStdString();
  ASSERT_EQ(plane.isEmpty(), recorded.isEmpty());
  for (int a = 0; a < 3; ++a) {
    EXPECT_NEAR(plane["position_mm"][a].toDouble(), recorded["position_mm"][a].toDouble(), 1);
    EXPECT_NEAR(plane["normal"][a].toDouble(), recorded["normal"][a].toDouble(), 0.06);
  }
}

/// Compares two states of a scene, bit for bit.
void expect_same_bits(const Scene& a, const Scene& b) {
  EXPECT_EQ(a.measurements, b.measurements);
  EXPECT_EQ(a.layers, b.layers);
  ASSERT_EQ(a.meshes.size(), b.meshes.size());
  for (std::size_t m = 0; m < a.meshes.size(); ++m) {
    EXPECT_EQ(a.meshes[m].name, b.meshes[m].name);
    EXPECT_EQ(a.meshes[m].locked, b.meshes[m].locked);
    EXPECT_EQ(a.meshes[m].model_identity(), b.meshes[m].model_identity());
    EXPECT_EQ(a.meshes[m].start_modes, b.meshes[m].start_modes);
    EXPECT_EQ(a.meshes[m].mesh.positions, b.meshes[m].mesh.positions);
    EXPECT_EQ(a.meshes[m].intensity_range, b.meshes[m].intensity_range);
    ASSERT_EQ(a.meshes[m].has_field(), b.meshes[m].has_field());
    if (a.meshes[m].has_field()) {
      EXPECT_EQ(a.meshes[m].field->values, b.meshes[m].field->values);
    }
  }
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t p = 0; p < a.points.size(); ++p) {
    EXPECT_EQ(a.points[p].position_mm, b.points[p].position_mm);
    EXPECT_EQ(a.points[p].path_mm, b.points[p].path_mm);
    EXPECT_EQ(a.points[p].radius_mm, b.points[p].radius_mm);
  }
}

}  // namespace

void expect_similar(const QJsonObject& got, const QJsonObject& expected) {
  for (const char* exact : {"points", "undo", "redo"}) EXPECT_EQ(got[exact], expected[exact]) << exact;
  expect_similar_display(got["display"].toObject(), expected["display"].toObject());
  EXPECT_EQ(got["measurements"].toArray(), expected["measurements"].toArray());
  EXPECT_EQ(got["layers"].toArray(), expected["layers"].toArray());
  EXPECT_EQ(got["filters"].toArray(), expected["filters"].toArray());
  const QJsonArray meshes = got["meshes"].toArray(), recorded = expected["meshes"].toArray();
  ASSERT_EQ(meshes.size(), recorded.size());
  for (int m = 0; m < meshes.size(); ++m) {
    const QJsonValue a = meshes[m], b = recorded[m];
    SCOPED_TRACE(b["name"].toString().toStdString());
    EXPECT_EQ(a["name"], b["name"]);
    EXPECT_EQ(a["vertices"], b["vertices"]);
    EXPECT_EQ(a["range"], b["range"]);
    for (const char* exact : {"images", "model", "modes"}) EXPECT_EQ(a[exact], b[exact]) << exact;
    EXPECT_NEAR(a["earlier_ml"].toDouble(), b["earlier_ml"].toDouble(), 0.2);
    EXPECT_NEAR(a["volume_mm3"].toDouble(), b["volume_mm3"].toDouble(), 0.01 * b["volume_mm3"].toDouble());
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(a["centre_mm"][axis].toDouble(), b["centre_mm"][axis].toDouble(), 0.1);
  }
  const QJsonObject labels = got["labels"].toObject(), recorded_labels = expected["labels"].toObject();
  EXPECT_EQ(labels.keys(), recorded_labels.keys());
  for (const QString& label : recorded_labels.keys())
    EXPECT_NEAR(labels[label].toInt(), recorded_labels[label].toInt(), 0.015 * recorded_labels[label].toInt());
}

void expect_same_bits_after_undo(Workbench& bench, bool opened) {
  std::vector<Scene> states{bench.scene()};
  while (bench.session().can_undo()) bench.apply(Undo{}), states.push_back(bench.scene());
  EXPECT_TRUE(opened || (bench.scene().meshes.empty() && bench.scene().points.empty() &&
                         bench.scene().measurements.empty() && bench.scene().layers.empty()));
  for (auto state = states.rbegin(); state != states.rend(); ++state) {
    expect_same_bits(bench.scene(), *state);
    if (state + 1 != states.rend()) bench.apply(Redo{});
  }
}

}  // namespace simplexseg
