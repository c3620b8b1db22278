// SPDX-License-Identifier: Apache-2.0
#include "firmware/machine_config.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "firmware/optics/nominal_geometry.hpp"
#include "firmware/test_host.hpp"
#include "firmware/test_views.hpp"

namespace tetragauge {
namespace {

tg_Config part_of(const MachineConfig& config, tg_ConfigPart part) {
  tg_Config message = tg_Config_init_zero;
  EXPECT_TRUE(get_part(config, part, &message));
  return message;
}

constexpr tg_ConfigPart kParts[] = {tg_ConfigPart_CONFIG_GALVO,    tg_ConfigPart_CONFIG_CAMERA_1,
                                    tg_ConfigPart_CONFIG_CAMERA_2, tg_ConfigPart_CONFIG_STAGE,
                                    tg_ConfigPart_CONFIG_MEASURE,  tg_ConfigPart_CONFIG_VOLUME};

TEST(MachineConfig, NominalIsValidAndIsTheNominalGeometry) {
  const MachineConfig config = nominal_config();
  for (tg_ConfigPart part : kParts) EXPECT_EQ(config_error(part_of(config, part)), nullptr);
  const auto geometry = geometry_of<double>(config);
  const auto nominal = nominal_geometry<double>();
  EXPECT_EQ(geometry.galvo.a_axis, nominal.galvo.a_axis);
  EXPECT_EQ(geometry.galvo.b_normal, nominal.galvo.b_normal);
  EXPECT_EQ(geometry.galvo.beam_point, nominal.galvo.beam_point);
  EXPECT_NEAR(geometry.galvo.direction_sigma_rad, nominal.galvo.direction_sigma_rad, 1e-18);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(geometry.camera[i].centre, nominal.camera[i].centre);
    EXPECT_EQ(geometry.camera[i].x_axis, nominal.camera[i].x_axis);
    EXPECT_EQ(geometry.camera[i].focal_mm, nominal.camera[i].focal_mm);
    EXPECT_EQ(geometry.camera[i].half_size_mm, nominal.camera[i].half_size_mm);
  }
  EXPECT_EQ(geometry.stage.axis_direction, nominal.stage.axis_direction);
  EXPECT_EQ(geometry.volume.max, nominal.volume.max);
}

TEST(MachineConfig, StepsAndBack) {
  const MachineConfig config = nominal_config();
  EXPECT_EQ(table_steps(config, 45'000'000), 4'500);
  EXPECT_EQ(table_steps(config, -45'004'999), -4'500);
  EXPECT_EQ(table_steps(config, -45'005'001), -4'501);
  EXPECT_EQ(slide_steps(config, 100'002), 20'000);
  EXPECT_EQ(slide_steps(config, 100'003), 20'001);
  EXPECT_EQ(table_udeg(config, -4'500), -45'000'000);
  EXPECT_EQ(slide_um(config, 20'001), 100'005);
}

TEST(MachineConfig, BadPartsAreNamed) {
  const MachineConfig good = nominal_config();
  const auto error_after = [&](tg_ConfigPart part, void (*spoil)(tg_Config&)) {
    tg_Config message = part_of(good, part);
    spoil(message);
    const char* error = config_error(message);
    return std::string(error ? error : "");
  };
  EXPECT_NE(error_after(tg_ConfigPart_CONFIG_GALVO, [](tg_Config& c) { c.part.galvo.a_axis.x = 2; }), "");
  EXPECT_NE(
      error_after(tg_ConfigPart_CONFIG_GALVO, [](tg_Config& c) { c.part.galvo.b_scale = std::nan(""); }), "");
  EXPECT_NE(error_after(tg_ConfigPart_CONFIG_GALVO, [](tg_Config& c) { c.part.galvo.limit_urad = 300'000; }),
            "");
  EXPECT_NE(error_after(tg_ConfigPart_CONFIG_CAMERA_1, [](tg_Config& c) { c.part.camera.index = 2; }), "");
  EXPECT_NE(error_after(tg_ConfigPart_CONFIG_CAMERA_1, [](tg_Config& c) { c.part.camera.focal_mm = 0; }), "");
  EXPECT_NE(
      error_after(tg_ConfigPart_CONFIG_CAMERA_2, [](tg_Config& c) { c.part.camera.centre_mm.y = HUGE_VAL; }),
      "");
  EXPECT_NE(error_after(tg_ConfigPart_CONFIG_CAMERA_2,
                        [](tg_Config& c) { c.part.camera.y_axis = c.part.camera.x_axis; }),
            "");
  EXPECT_NE(
      error_after(tg_ConfigPart_CONFIG_CAMERA_2, [](tg_Config& c) { c.part.camera.distortion_x[3] = 5; }),
      "");
  EXPECT_NE(error_after(tg_ConfigPart_CONFIG_STAGE, [](tg_Config& c) { c.part.stage.slide_steps_per_m = 0; }),
            "");
  EXPECT_NE(
      error_after(tg_ConfigPart_CONFIG_STAGE, [](tg_Config& c) { c.part.stage.table.acceleration = 10; }),
      "");
  EXPECT_NE(
      error_after(tg_ConfigPart_CONFIG_STAGE, [](tg_Config& c) { c.part.stage.slide.home_steps = 500; }), "");
  EXPECT_NE(error_after(tg_ConfigPart_CONFIG_MEASURE, [](tg_Config& c) { c.part.measure.rail_codes = 0; }),
            "");
  EXPECT_NE(error_after(tg_ConfigPart_CONFIG_VOLUME, [](tg_Config& c) { c.part.volume.max_mm.z = -3; }), "");
  EXPECT_STREQ(config_error(tg_Config_init_zero), "config: holds no part");
}

TEST(MachineConfig, EveryPartChangesTheIdentity) {
  std::set<uint32_t> identities = {config_crc(nominal_config())};
  const auto with = [](void (*change)(MachineConfig&)) {
    MachineConfig config = nominal_config();
    change(config);
    return config_crc(config);
  };
  identities.insert(with([](MachineConfig& c) { c.galvo.a_zero_urad = 1; }));
  identities.insert(with([](MachineConfig& c) { c.camera[0].tilt_x_rad = 1e-9; }));
  identities.insert(with([](MachineConfig& c) { c.camera[1].tilt_x_rad = 1e-9; }));
  identities.insert(with([](MachineConfig& c) { c.stage.slide.backlash_steps += 1; }));
  identities.insert(with([](MachineConfig& c) { c.measure.settle_base_us += 1; }));
  identities.insert(with([](MachineConfig& c) { c.volume.min_mm.x -= 1; }));
  EXPECT_EQ(identities.size(), 7u);
}

TEST(MachineConfig, IsSetAndReadOverTheLine) {
  TestHost host;
  host.connect();
  ASSERT_TRUE(host.home());
  tg_HostMessage get = tg_HostMessage_init_zero;
  get.which_body = tg_HostMessage_get_config_tag;
  tg_HostMessage set = tg_HostMessage_init_zero;
  set.which_body = tg_HostMessage_set_config_tag;
  for (tg_ConfigPart part : kParts) {
    get.body.get_config.part = part;
    const tg_MachineMessage reply = host.ask(get);
    ASSERT_EQ(reply.which_body, tg_MachineMessage_config_tag);
    set.body.set_config = reply.body.config;
    EXPECT_EQ(host.ask(set).which_body, tg_MachineMessage_done_tag);
  }
  EXPECT_EQ(host.controller->state(), tg_State_STATE_IDLE) << "another stage must be homed again";
  EXPECT_EQ(host.ask(tg_HostMessage_get_status_tag).body.status.config_crc, config_crc(nominal_config()));

  set.body.set_config = part_of(nominal_config(), tg_ConfigPart_CONFIG_CAMERA_2);
  set.body.set_config.part.camera.focal_mm = 36;
  EXPECT_EQ(host.ask(set).which_body, tg_MachineMessage_done_tag);
  MachineConfig changed = nominal_config();
  changed.camera[1].focal_mm = 36;
  EXPECT_EQ(host.ask(tg_HostMessage_get_status_tag).body.status.config_crc, config_crc(changed));
  set.body.set_config.part.camera.focal_mm = -1;
  EXPECT_EQ(host.ask(set).body.refused.reason, tg_RefuseReason_REFUSE_OUT_OF_RANGE);
  EXPECT_EQ(host.ask(tg_HostMessage_get_status_tag).body.status.config_crc, config_crc(changed));
}

}  // namespace
}  // namespace tetragauge
