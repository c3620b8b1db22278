// SPDX-License-Identifier: Apache-2.0
// What each peripheral is told, write by write: lists made by hand from RM0090's register descriptions (reset
// values and bits), not from what the code does.
#include <gtest/gtest.h>

#include <memory>

#include "boards/stm32_h405/recorded_bus.hpp"
#include "boards/stm32_h405/stm32_board.hpp"

namespace tetragauge {
namespace {

static_assert(Board<Stm32Board<RecordedBus, BuiltInMirrors>>);
static_assert(Board<Stm32Board<RecordedBus, Ad5754rMirrors>>);

using Golden = std::vector<std::string>;
using Bus = RecordedBus;

class InitSequence : public testing::Test {
 protected:
  void SetUp() override { Bus::reset(); }
  WaitFaults faults;
};

// Fails with the first difference, both lists beside each other.
void expect_writes(const Golden& golden) {
  EXPECT_EQ(Bus::take_writes(), golden);
}

Golden operator+(Golden a, const Golden& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST_F(InitSequence, ClocksFromTheCrystal) {
  // The hardware: ready bits follow, SWS follows SW.
  Bus::on_write = [](uint32_t address, uint32_t value) {
    if (address == 0x40023800) Bus::cells[address] = value | (value & 0x0101'0000) << 1;
    if (address == 0x40023808) Bus::cells[address] = value | (value & 3) << 2;
  };
  start_clocks<Bus>(faults);
  expect_writes(Golden{
      "RCC_APB1ENR = 10000000",  // PWREN
      "PWR_CR = 00004000",       // VOS: scale 1
      "RCC_CR = 00010083",       // HSEON
      "RCC_PLLCFGR = 27405408",  // Q 7, from HSE, P / 2, N 336, M 8; bit 29 kept
      "RCC_CR = 01030083",       // PLLON
      "FLASH_ACR = 00000705",    // caches, prefetch, 5 wait states
      "RCC_CFGR = 00009400",     // APB2 / 2, APB1 / 4
      "RCC_CFGR = 00009402",     // SW: PLL
  });
  EXPECT_FALSE(faults.any());
}

TEST_F(InitSequence, ClocksWithoutTheCrystalComeFromTheInternalOscillator) {
  Bus::on_write = [](uint32_t address, uint32_t value) {
    if (address == 0x40023800) Bus::cells[address] = value | (value & 0x0100'0000) << 1;
    if (address == 0x40023808) Bus::cells[address] = value | (value & 3) << 2;
  };
  start_clocks<Bus>(faults);
  expect_writes(Golden{"RCC_APB1ENR = 10000000", "PWR_CR = 00004000", "RCC_CR = 00010083",
                       "RCC_PLLCFGR = 27005410",  // from HSI, M 16
                       "RCC_CR = 01010083", "FLASH_ACR = 00000705", "RCC_CFGR = 00009400",
                       "RCC_CFGR = 00009402"});
  EXPECT_TRUE(faults.has(WaitFault::kCrystal));
  EXPECT_TRUE(faults.measuring_is_off());
}

TEST_F(InitSequence, ClocksStayWhereTheyAreWithoutThePll) {
  start_clocks<Bus>(faults);  // no ready bit ever comes
  EXPECT_TRUE(faults.has(WaitFault::kCrystal) && faults.has(WaitFault::kPll));
  EXPECT_EQ(Bus::cells[0x40023808] & 3, 0u);
}

const Golden kLinePins = {
    // PA9: function 7, fast, no pull, alternate; PA10: the same, pulled up
    "GPIOA_AFRH = 00000070", "GPIOA_OSPEEDR = 0C080000", "GPIOA_PUPDR = 64000000", "GPIOA_MODER = A8080000",
    "GPIOA_AFRH = 00000770", "GPIOA_OSPEEDR = 0C280000", "GPIOA_PUPDR = 64100000", "GPIOA_MODER = A8280000"};

TEST_F(InitSequence, SerialLineByDma) {
  auto line = std::make_unique<SerialLine<Bus>>();
  line->begin(clock_tree::usart_divider(921'600), true);
  expect_writes(kLinePins + Golden{
                                "USART1_BRR = 0000005B",  // 84 MHz / 921,600 = 91.1
                                "DMA2_S2CR = 00000000", "DMA2_LIFCR = 003D0000",
                                "DMA2_S2PAR = 40011004",  // USART1_DR
                                "DMA2_S2M0AR = 20000000", "DMA2_S2NDTR = 00000400",
                                "DMA2_S2CR = 08010501",  // channel 4, MINC, CIRC, EN
                                "DMA2_S7CR = 00000000", "DMA2_HIFCR = 0F400000", "DMA2_S7PAR = 40011004",
                                "USART1_CR3 = 000000C0",  // DMAT, DMAR
                                "USART1_CR1 = 0000201C",  // UE, IDLEIE, TE, RE
                            });
  const uint8_t bytes[] = {1, 2, 3};
  EXPECT_EQ(line->write(bytes, 3), 3u);
  expect_writes(Golden{"DMA2_S7M0AR = 20010000", "DMA2_S7NDTR = 00000003",
                       "DMA2_S7CR = 08000451"});  // channel 4, MINC, to peripheral, TCIE, EN
}

TEST_F(InitSequence, SerialLineByInterruptsAtTwoMegabaud) {
  auto line = std::make_unique<SerialLine<Bus>>();
  line->begin(clock_tree::usart_divider(2'000'000), false);
  expect_writes(kLinePins + Golden{"USART1_BRR = 0000002A",    // 84 MHz / 42
                                   "USART1_CR1 = 0000202C"});  // UE, RXNEIE, TE, RE
}

TEST_F(InitSequence, DmaCopy) {
  EXPECT_FALSE(dma_works<Bus>(10));
  expect_writes(Golden{"DMA2_S1CR = 00000000", "DMA2_LIFCR = 00000F40", "DMA2_S1PAR = 20000000",
                       "DMA2_S1M0AR = 20010000", "DMA2_S1NDTR = 00000004",
                       "DMA2_S1FCR = 00000007",   // DMDIS, full threshold
                       "DMA2_S1CR = 00005681"});  // words, MINC, PINC, memory to memory, EN
}

TEST_F(InitSequence, StepTimer) {
  StepTimer<Bus> steps;
  steps.begin();
  expect_writes(Golden{
      "GPIOC_BSRR = 00400000", "GPIOC_MODER = 00001000",  // PC6, PC7, PC8 low, then outputs
      "GPIOC_BSRR = 00800000", "GPIOC_MODER = 00005000", "GPIOC_BSRR = 01000000", "GPIOC_MODER = 00015000",
      "TIM2_CCMR2 = 00004040",  // OC4M, OC3M: forced inactive
      "TIM2_CCER = 00001100",   // CC4E, CC3E
      "TIM2_PSC = 00000000", "TIM2_ARR = FFFFFFFF",
      "TIM2_CR1 = 00000004",  // URS
      "TIM2_EGR = 00000001",  // UG
      "TIM2_SR = 00000000", "TIM2_DIER = 00000001", "TIM2_CR1 = 00000005",
      // PA2 and PA3: function 1, medium, pulled down, alternate
      "GPIOA_AFRL = 00000100", "GPIOA_OSPEEDR = 0C000010", "GPIOA_PUPDR = 64000020", "GPIOA_MODER = A8000020",
      "GPIOA_AFRL = 00001100", "GPIOA_OSPEEDR = 0C000050", "GPIOA_PUPDR = 640000A0", "GPIOA_MODER = A80000A0",
      "GPIOC_BSRR = 00000100",  // motors on
  });
}

TEST_F(InitSequence, AlarmClock) {
  AlarmClock<Bus> clock;
  clock.begin();
  expect_writes(Golden{"TIM5_PSC = 00000000", "TIM5_ARR = FFFFFFFF", "TIM5_CR1 = 00000004",
                       "TIM5_EGR = 00000001", "TIM5_SR = 00000000", "TIM5_DIER = 00000001",
                       "TIM5_CR1 = 00000005"});
}

TEST_F(InitSequence, SamplerAndABurst) {
  Sampler<Bus> sampler;
  sampler.begin();
  expect_writes(Golden{
      "GPIOC_MODER = 00000003", "GPIOC_MODER = 0000000F", "GPIOC_MODER = 0000003F", "GPIOC_MODER = 000000FF",
      "GPIOA_MODER = A8003000", "GPIOA_MODER = A800F000", "GPIOB_MODER = 00000283", "GPIOB_MODER = 0000028F",
      "ADC_CCR = 00010006",   // ADCPRE / 4, MULTI: regular simultaneous
      "ADC1_CR1 = 00000100",  // SCAN
      "ADC1_SMPR2 = 00000000",
      "ADC1_SMPR1 = 00000492",  // 28 cycles on 10 to 13
      "ADC1_SQR3 = 0006B16A",   // 10, 11, 12, 13
      "ADC1_SQR1 = 00300000",   // four
      "ADC1_CR2 = 00000001",    // ADON
      "ADC2_CR1 = 00000100",
      "ADC2_SMPR2 = 12480000",  // 28 cycles on 6 to 9
      "ADC2_SMPR1 = 00000000",
      "ADC2_SQR3 = 0004A0E6",  // 6, 7, 8, 9
      "ADC2_SQR1 = 00300000",   "ADC2_CR2 = 00000001",
      "ADC1_CR2 = 1E000001",  // rising edge of TIM8_TRGO
      "TIM8_PSC = 00000000",
      "TIM8_ARR = 0000068F",    // 168 MHz / 1,680 = 100 kHz
      "TIM8_CCR1 = 00000190",   // 2.38 us; the four pairs take 7.62
      "TIM8_CCMR1 = 00000070",  // OC1M: PWM mode 2
      "TIM8_CR2 = 00000040",    // MMS: OC1REF
  });
  PsdSample samples[64];
  sampler.start(samples, 64, faults);
  expect_writes(Golden{
      "TIM8_CR1 = 00000008",  // OPM, CEN off
      "ADC_CCR = 00010006", "DMA2_S0CR = 00000000", "ADC1_SR = 00000000", "ADC2_SR = 00000000",
      "DMA2_LIFCR = 0000003D",
      "DMA2_S0PAR = 40012308",  // ADC_CDR
      "DMA2_S0M0AR = 20000000", "DMA2_S0NDTR = 00000100",
      "DMA2_S0CR = 00035411",  // very high, words, MINC, TCIE, EN
      "ADC_CCR = 00018006",    // DMA mode 2
      "TIM8_RCR = 0000003F",   // 64 triggers and no more
      "TIM8_EGR = 00000001",   // UG
      "TIM8_CR1 = 00000009",   // OPM, CEN
  });
}

TEST_F(InitSequence, BuiltInMirrors) {
  BuiltInMirrors<Bus> mirrors;
  mirrors.begin(faults);
  expect_writes(Golden{"GPIOA_MODER = A8000300", "GPIOA_MODER = A8000F00",
                       "DAC_DHR12RD = 08000800",  // both in the middle before they are on
                       "DAC_CR = 00010001"});
  mirrors.set(32'767, -32'768, faults);
  mirrors.set(16, -16, faults);
  mirrors.set(7, 8, faults);
  expect_writes(Golden{"DAC_DHR12RD = 00000FFF", "DAC_DHR12RD = 07FF0801", "DAC_DHR12RD = 08010800"});
  // As far as the firmware goes with nominal numbers: 28,333 codes, 2,048 + 1,771 of 12 bits, 3.077 V of 3.3.
  constexpr auto furthest = static_cast<int16_t>(BuiltInMirrors<Bus>::kReachUrad / kUradPerMirrorCode);
  mirrors.set(furthest, -furthest, faults);
  expect_writes(Golden{"DAC_DHR12RD = 01150EEB"});
}

Golden spi_word(const char* high, const char* middle, const char* low) {
  return {"GPIOB_BSRR = 04000000",  // SYNC low
          std::string("SPI2_DR = 000000") + high, std::string("SPI2_DR = 000000") + middle,
          std::string("SPI2_DR = 000000") + low, "GPIOB_BSRR = 00000400"};
}
const Golden kLoad = {"GPIOB_BSRR = 08000000", "GPIOB_BSRR = 00000800"};

TEST_F(InitSequence, Ad5754rMirrors) {
  Ad5754rMirrors<Bus> mirrors;
  mirrors.begin(faults);
  EXPECT_EQ(
      Bus::take_writes(),
      (Golden{"GPIOB_BSRR = 04000000", "GPIOB_MODER = 00100280", "GPIOB_BSRR = 08000000",
              "GPIOB_MODER = 00500280", "GPIOB_BSRR = 00000400", "GPIOB_BSRR = 00000800",  // SYNC, LDAC high
              "GPIOB_AFRH = 00500000", "GPIOB_OSPEEDR = 080000C0", "GPIOB_PUPDR = 00000100",
              "GPIOB_MODER = 08500280", "GPIOB_AFRH = 50500000", "GPIOB_OSPEEDR = 880000C0",
              "GPIOB_PUPDR = 00000100", "GPIOB_MODER = 88500280", "SPI2_CR1 = 00000345"}
       // SSM, SSI, SPE, MSTR, / 2, CPHA
       + spi_word("10", "00", "13")  // power: A, B, reference
       + spi_word("0C", "00", "04")  // range of all: +-10 V
       + spi_word("00", "00", "00") + spi_word("01", "00", "00") + kLoad));
  mirrors.set(1, -2, faults);
  expect_writes(spi_word("00", "00", "01") + spi_word("01", "FF", "FE") + kLoad);
  EXPECT_FALSE(faults.any());
  Bus::cells[0x40003808] = 0x82;  // BSY stays
  mirrors.set(0, 0, faults);
  EXPECT_TRUE(faults.has(WaitFault::kMirrorConverter));
}

TEST_F(InitSequence, Inputs) {
  InputPins<Bus> inputs;
  inputs.begin();
  expect_writes(Golden{
      // PB7, PB8, PB9, PB5, PC9, PC10: pulled down, in
      "GPIOB_PUPDR = 00008100",
      "GPIOB_MODER = 00000280",
      "GPIOB_PUPDR = 00028100",
      "GPIOB_MODER = 00000280",
      "GPIOB_PUPDR = 000A8100",
      "GPIOB_MODER = 00000280",
      "GPIOB_PUPDR = 000A8900",
      "GPIOB_MODER = 00000280",
      "GPIOC_PUPDR = 00080000",
      "GPIOC_MODER = 00000000",
      "GPIOC_PUPDR = 00280000",
      "GPIOC_MODER = 00000000",
      // PB6: function 2 (TIM4_CH1), slow, pulled down
      "GPIOB_AFRL = 02000000",
      "GPIOB_OSPEEDR = 000000C0",
      "GPIOB_PUPDR = 000AA900",
      "GPIOB_MODER = 00002280",
      "TIM4_CR1 = 00000200",    // CKD: / 4
      "TIM4_CCMR1 = 000000F1",  // IC1F: / 32, 8 looks; CC1S: TI1
      "TIM4_CCER = 0000000B",   // CC1NP, CC1P, CC1E: both edges
      "TIM4_SR = 00000000",
      "TIM4_DIER = 00000002",  // CC1IE
      "TIM4_CR1 = 00000201",
  });
}

TEST_F(InitSequence, Laser) {
  LaserSwitch<Bus> laser;
  laser.begin();
  expect_writes(Golden{"GPIOB_BSRR = 10000000", "GPIOB_MODER = 01000280", "GPIOB_BSRR = 40000000",
                       "GPIOB_MODER = 11000280"});
}

TEST_F(InitSequence, Watchdog) {
  Watchdog<Bus> watchdog;
  watchdog.begin(faults);
  expect_writes(Golden{"IWDG_KR = 0000CCCC", "IWDG_KR = 00005555",
                       "IWDG_PR = 00000004",   // / 64
                       "IWDG_RLR = 0000095F",  // 2,400
                       "IWDG_KR = 0000AAAA"});
  EXPECT_FALSE(faults.any());
}

TEST_F(InitSequence, FlashEraseAndWrite) {
  FlashStorage<Bus> storage(faults);
  ASSERT_TRUE(storage.erase(1));
  expect_writes(Golden{"FLASH_SR = 000000F3",  // clears EOP, OPERR and the four errors
                       "FLASH_KEYR = 45670123", "FLASH_KEYR = CDEF89AB",
                       "FLASH_CR = 0000025A",    // PSIZE x32, SNB 11, SER
                       "FLASH_CR = 0001025A"});  // STRT
  Bus::cells[0x40023C0C] = 0;
  Bus::cells[0x40023C00] = 0x705;
  const Golden kFinish = {"FLASH_CR = 80000000", "FLASH_ACR = 00000305", "FLASH_ACR = 00001305",
                          "FLASH_ACR = 00000305", "FLASH_ACR = 00000705"};
  EXPECT_FALSE(storage.busy());
  expect_writes(kFinish);
  const uint32_t words[] = {0x1234'5678, 0x9ABC'DEF0};
  Bus::on_write = [](uint32_t address, uint32_t) {
    if (address == 0x40023C0C) Bus::cells[address] = 0;  // cleared by writing 1
  };
  ASSERT_TRUE(storage.write(0, 3, words, 2));
  expect_writes(Golden{"FLASH_SR = 000000F3", "FLASH_KEYR = 45670123", "FLASH_KEYR = CDEF89AB",
                       "FLASH_CR = 00000201",  // PSIZE x32, PG
                       "080C000C = 12345678", "080C0010 = 9ABCDEF0"} +
                kFinish);
}

}  // namespace
}  // namespace tetragauge
