// SPDX-License-Identifier: Apache-2.0
// Parameters with unit, default and help; presets; order of the cards and duplicates.
#include <QCheckBox>
#include <QDoubleSpinBox>
#include <QFile>
#include <QLabel>
#include <QTest>
#include <QToolButton>

#include "gui/panels/force_panel.h"
#include "gui/panels/mesh_card.h"
#include "gui/panels/mesh_panel.h"
#include "gui/panels/parameter_help.h"
#include "gui/panels/parameter_row.h"
#include "gui/panels/preset_menu.h"
#include "gui/panels/simulation_panel.h"
#include "step/simulation_parameters.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class TuneTest : public PausedPhantomTest {
 protected:
  PresetMenu& presets() { return *window_->findChild<PresetMenu*>("presets"); }
  const std::vector<MeshCard*>& cards() { return window_->findChild<MeshPanel*>()->cards(); }
  std::vector<std::string> names() {
    std::vector<std::string> names;
    for (const MeshItem& item : scene().meshes) names.push_back(item.name);
    return names;
  }
};

TEST_F(TuneTest, EveryParameterHasUnitDefaultHelpAndReset) {
  ForcePanel& forces = window_->panels().forces();
  auto* help = forces.findChild<QLabel*>("parameter_help");
  ASSERT_NE(help, nullptr);
  for (const ForceInfo& force : force_list()) {
    for (std::size_t p = 0; p < force.parameters.size(); ++p) {
      const ParameterInfo& info = force.parameters[p];
      ParameterRow* row = forces.row(force.id, static_cast<int>(p));
      QEnterEvent enter(QPointF(1, 1), QPointF(1, 1), QPointF(1, 1));
      QApplication::sendEvent(row, &enter);
      EXPECT_TRUE(help->text().contains(QString::fromUtf8(info.doc).left(30).toHtmlEscaped())) << info.name;
      EXPECT_TRUE(help->text().contains("Default ")) << info.name;
      if (*info.unit && row->number()) {
        EXPECT_TRUE(row->number()->suffix().contains(info.unit)) << info.name;
      }
      row->set_value(info.default_value);
      EXPECT_FALSE(row->reset()->isEnabled()) << info.name;
      EXPECT_EQ(row->reset()->toolTip(), "The value is the default");
    }
  }
  EXPECT_TRUE(help_of(force_list()[0].parameters[0]).contains("from "));
}

TEST_F(TuneTest, ResetIsOneActionThatCanBeUndone) {
  const ItemId mesh = scene().meshes[0].id;
  ParameterRow* row = window_->panels().forces().row(ForceId::Smoothing, 0);
  const float standard = row->info().default_value;
  bench().apply(SetForceParameter{mesh, ForceId::Smoothing, 0, standard / 2});
  ASSERT_TRUE(row->reset()->isEnabled());
  EXPECT_TRUE(row->reset()->toolTip().startsWith("Reset to the default"));
  row->reset()->click();
  EXPECT_EQ(scene().meshes[0].parameters.weight(ForceId::Smoothing), standard);
  bench().apply(Undo{});
  EXPECT_EQ(scene().meshes[0].parameters.weight(ForceId::Smoothing), standard / 2);
  const int final_vertices = find_parameter(simulation_table(), "final_vertices");
  ParameterRow* other = window_->panels().simulation().row(final_vertices);
  bench().apply(SetSimulationParameter{final_vertices, 20});
  other->reset()->click();
  EXPECT_EQ(value_of(scene().simulation, final_vertices), other->info().default_value);
}

TEST_F(TuneTest, APresetIsSavedAppliedToAnotherMeshAndUndoneAtOnce) {
  const ItemId first = scene().meshes[0].id;
  bench().apply(SetForceParameter{first, ForceId::Gradient, 0, 0.75f});
  bench().apply(SetSimulationParameter{find_parameter(simulation_table(), "final_vertices"), 320});
  const QString path = folder_.filePath("mine.preset.json");
  ASSERT_TRUE(presets().save_to(path));
  ItemId second = 0;
  bench().apply(AddMesh{"second", Seed{bench().view.crosshair_mm, 5}, {}, 0}, &second);
  bench().pause();
  bench().apply(SetParameters{0, default_force_parameters(), default_simulation_parameters()});
  const auto gradient = [&](int mesh) { return scene().meshes[mesh].parameters.weight(ForceId::Gradient); };
  const float standard = gradient(0);
  ASSERT_NE(standard, 0.75f);
  bench().set_active_mesh(second);
  ASSERT_TRUE(presets().load_from(path));
  EXPECT_EQ(gradient(1), 0.75f);
  EXPECT_EQ(gradient(0), standard) << "the active one alone";
  EXPECT_EQ(scene().simulation.final_vertices, 320);
  bench().apply(Undo{});
  EXPECT_EQ(gradient(1), standard);
  EXPECT_NE(scene().simulation.final_vertices, 320);
  QFile broken(folder_.filePath("broken.preset.json"));
  ASSERT_TRUE(broken.open(QIODevice::WriteOnly));
  broken.write("{\"simplexseg_preset\": 1, \"forces\": {\"magic\": {}}}");
  broken.close();
  EXPECT_FALSE(presets().load_from(broken.fileName()));
  EXPECT_EQ(gradient(1), standard);
}

TEST_F(TuneTest, CardsAreOrderedByDragAndByKeys) {
  bench().apply(AddMesh{"b", Seed{bench().view.crosshair_mm, 5}, {}, 0});
  bench().apply(AddMesh{"c", Seed{bench().view.crosshair_mm, 4}, {}, 0});
  bench().pause();
  window_->resize(1200, 1000);
  ASSERT_TRUE(wait_until([&] { return cards()[2]->y() > cards()[1]->y() && cards()[1]->y() > cards()[0]->y(); }));
  MeshCard& first = *cards()[0];
  const auto below = [&](int card) {
    return QPointF(first.mapFromGlobal(cards()[card]->mapToGlobal(QPoint(3, cards()[card]->height() - 3))));
  };
  drag(first, QPointF(3, 3), below(1));
  EXPECT_EQ(names(), (std::vector<std::string>{"b", "object", "c"}));
  EXPECT_EQ(bench().view.active_mesh, scene().meshes[1].id);
  drag(*cards()[2], QPointF(3, 3), QPointF(cards()[2]->mapFromGlobal(cards()[0]->mapToGlobal(QPoint(3, 1)))));
  EXPECT_EQ(names(), (std::vector<std::string>{"c", "b", "object"}));
  drag(*cards()[1], QPointF(3, 3), QPointF(4, 4));  // a click
  EXPECT_EQ(names(), (std::vector<std::string>{"c", "b", "object"}));
  window_->actions()[Act::MeshUp]->trigger();
  EXPECT_EQ(names(), (std::vector<std::string>{"b", "c", "object"}));
  EXPECT_FALSE(window_->actions()[Act::MeshUp]->isEnabled());
  window_->actions()[Act::MeshDown]->trigger();
  bench().apply(Undo{});
  EXPECT_EQ(names(), (std::vector<std::string>{"b", "c", "object"}));
}

TEST_F(TuneTest, ACopyHasPoseAndPointsAndItsOwnName) {
  const ItemId mesh = scene().meshes[0].id;
  bench().apply(AddPoint{mesh, {0, 0, 14}});
  bench().pause();
  bench().advance_steps(5);
  window_->actions()[Act::DuplicateMesh]->trigger();
  EXPECT_EQ(names(), (std::vector<std::string>{"object", "object copy"}));
  const MeshItem &a = scene().meshes[0], &b = scene().meshes[1];
  EXPECT_EQ(a.mesh.positions, b.mesh.positions);
  EXPECT_NE(a.label, b.label);
  EXPECT_FALSE(a.colour == b.colour);
  ASSERT_EQ(scene().points.size(), 2u);
  EXPECT_EQ(scene().points[1].mesh, b.id);
  EXPECT_EQ(bench().view.active_mesh, b.id) << "the next changes apply to the copy";
  window_->actions()[Act::DuplicateMesh]->trigger();
  EXPECT_EQ(names().back(), "object copy copy");
}

}  // namespace
}  // namespace simplexseg
