#pragma once
/* What the sample of a finger uses of Zephyr's CAN controllers, declared as there. */
#include <zephyr/device.h>
#include <zephyr/kernel.h>
#define CAN_STD_ID_MASK 0x7FFU
#define CAN_MODE_FD (1U << 2)
#define CAN_FRAME_FDF (1U << 2)
#define CAN_FRAME_BRS (1U << 3)
struct can_frame {
    uint32_t id;
    uint8_t dlc;
    uint8_t flags;
    union {
        uint8_t data[64];
        uint32_t data_32[16];
    };
};
struct can_filter {
    uint32_t id;
    uint32_t mask;
    uint8_t flags;
};
typedef uint32_t can_mode_t;
typedef void (*can_tx_callback_t)(const struct device *dev, int error, void *user_data);
#define CAN_MSGQ_DEFINE(name, max_frames) static struct k_msgq name = {max_frames}
uint8_t can_dlc_to_bytes(uint8_t dlc);
uint8_t can_bytes_to_dlc(uint8_t bytes);
int can_set_mode(const struct device *dev, can_mode_t mode);
int can_start(const struct device *dev);
int can_send(const struct device *dev, const struct can_frame *frame, k_timeout_t timeout, can_tx_callback_t callback,
    void *user_data);
int can_add_rx_filter_msgq(const struct device *dev, struct k_msgq *queue, const struct can_filter *filter);
