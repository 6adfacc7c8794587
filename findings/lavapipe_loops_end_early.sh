#!/bin/sh
# A good engineer would guess: a shader's loop makes as many turns as it says, or the driver loses the device. Neither
# Vulkan nor SPIR-V has a limit for finite loops, and 70,000 turns take a fraction of a millisecond.
# What happens instead: lavapipe of Mesa 22.3.6 (Debian 12) ends a loop after 65,535 turns and goes on behind it as if
# its condition had become false. The count is shared by all loops that an invocation runs: after a first loop of 40,000
# turns a second one of 40,000 makes 25,534. All results are VK_SUCCESS, and the validation layers have nothing to say.
# Source: Mesa, src/gallium/auxiliary/gallivm/lp_bld_limits.h, LP_MAX_TGSI_LOOP_ITERATIONS: 65535, "shared between every
# loop". Newer Mesa is without it (seen: 26.2.6).
# Seen: mesa-vulkan-drivers 22.3.6-1+deb12u2.
# Usage: findings/lavapipe_loops_end_early.sh      exit code 0: as described; 1: no longer so; 2: something is missing
set -eu
for package in gcc libvulkan-dev glslang-tools mesa-vulkan-drivers; do
  dpkg-query -W "$package" >/dev/null 2>&1 || { echo "missing: apt-get install $package" >&2; exit 2; }
done
echo "mesa-vulkan-drivers $(dpkg-query -W -f '${Version}' mesa-vulkan-drivers) (described: 22.3.6-1+deb12u2)"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
cat >turns.comp <<'GLSL'
#version 450
layout(local_size_x = 64) in;
layout(push_constant) uniform Wanted { uint first, second; };
layout(std430, binding = 0) buffer Counted { uvec2 counted[]; };
void main() {
  uvec2 turns = uvec2(0);
  for (uint i = 0; i < first; ++i) ++turns.x;
  for (uint i = 0; i < second; ++i) ++turns.y;
  counted[gl_GlobalInvocationID.x] = turns;
}
GLSL
cat >turns.c <<'C'
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <vulkan/vulkan.h>

#include "turns.h"

#define OK(call)                             \
  do {                                       \
    VkResult r = (call);                     \
    if (r) {                                 \
      fprintf(stderr, "%s: %d\n", #call, r); \
      exit(2);                               \
    }                                        \
  } while (0)

int main(void) {
  VkInstance instance;
  VkApplicationInfo application = {VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_2};
  OK(vkCreateInstance(&(VkInstanceCreateInfo){VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &application},
                      NULL, &instance));
  VkPhysicalDevice devices[16], chosen = NULL;
  uint32_t count = 16;
  vkEnumeratePhysicalDevices(instance, &count, devices);
  VkPhysicalDeviceDriverProperties driver = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
  VkPhysicalDeviceProperties2 properties = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &driver};
  for (uint32_t i = 0; i < count && !chosen; ++i) {
    vkGetPhysicalDeviceProperties2(devices[i], &properties);
    if (driver.driverID == VK_DRIVER_ID_MESA_LLVMPIPE) chosen = devices[i];
  }
  if (!chosen) {
    fprintf(stderr, "no lavapipe\n");
    return 2;
  }
  printf("%s, %s\n", driver.driverName, driver.driverInfo);

  float priority = 1;
  VkDevice device;
  VkDeviceQueueCreateInfo queues = {VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, .queueCount = 1,
                                    .pQueuePriorities = &priority};
  OK(vkCreateDevice(chosen,
                    &(VkDeviceCreateInfo){VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, .queueCreateInfoCount = 1,
                                          .pQueueCreateInfos = &queues},
                    NULL, &device));
  VkQueue queue;
  vkGetDeviceQueue(device, 0, 0, &queue);

  enum { kBytes = 64 * 8 };
  VkBuffer buffer;
  OK(vkCreateBuffer(device,
                    &(VkBufferCreateInfo){VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = kBytes,
                                          .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT},
                    NULL, &buffer));
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(device, buffer, &needs);
  VkPhysicalDeviceMemoryProperties memories;
  vkGetPhysicalDeviceMemoryProperties(chosen, &memories);
  const VkMemoryPropertyFlags wanted = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  uint32_t type = 0;
  while (!(needs.memoryTypeBits >> type & 1) || (memories.memoryTypes[type].propertyFlags & wanted) != wanted) ++type;
  VkDeviceMemory memory;
  OK(vkAllocateMemory(device,
                      &(VkMemoryAllocateInfo){VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = needs.size,
                                              .memoryTypeIndex = type},
                      NULL, &memory));
  OK(vkBindBufferMemory(device, buffer, memory, 0));
  uint32_t* counted;
  OK(vkMapMemory(device, memory, 0, VK_WHOLE_SIZE, 0, (void**)&counted));

  VkDescriptorSetLayoutBinding binding = {0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, NULL};
  VkDescriptorSetLayout setLayout;
  OK(vkCreateDescriptorSetLayout(device,
                                 &(VkDescriptorSetLayoutCreateInfo){VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                                                    .bindingCount = 1, .pBindings = &binding},
                                 NULL, &setLayout));
  VkPushConstantRange range = {VK_SHADER_STAGE_COMPUTE_BIT, 0, 8};
  VkPipelineLayout layout;
  OK(vkCreatePipelineLayout(device,
                            &(VkPipelineLayoutCreateInfo){VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                                          .setLayoutCount = 1, .pSetLayouts = &setLayout,
                                                          .pushConstantRangeCount = 1, .pPushConstantRanges = &range},
                            NULL, &layout));
  VkShaderModule module;
  OK(vkCreateShaderModule(device,
                          &(VkShaderModuleCreateInfo){VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                                      .codeSize = sizeof turns_spirv, .pCode = turns_spirv},
                          NULL, &module));
  VkPipeline pipeline;
  VkComputePipelineCreateInfo compute = {
      VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO, .layout = layout,
      .stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                .module = module, .pName = "main"}};
  OK(vkCreateComputePipelines(device, VK_NULL_HANDLE, 1, &compute, NULL, &pipeline));
  VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1};
  VkDescriptorPool pool;
  OK(vkCreateDescriptorPool(device,
                            &(VkDescriptorPoolCreateInfo){VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, .maxSets = 1,
                                                          .poolSizeCount = 1, .pPoolSizes = &size},
                            NULL, &pool));
  VkDescriptorSet set;
  OK(vkAllocateDescriptorSets(
      device,
      &(VkDescriptorSetAllocateInfo){VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, .descriptorPool = pool,
                                     .descriptorSetCount = 1, .pSetLayouts = &setLayout},
      &set));
  VkDescriptorBufferInfo info = {buffer, 0, VK_WHOLE_SIZE};
  vkUpdateDescriptorSets(
      device, 1,
      &(VkWriteDescriptorSet){VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, .dstSet = set, .descriptorCount = 1,
                              .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, .pBufferInfo = &info},
      0, NULL);
  VkCommandPool commandPool;
  OK(vkCreateCommandPool(device, &(VkCommandPoolCreateInfo){VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO}, NULL,
                         &commandPool));

  const uint32_t cases[][2] = {{60000, 0}, {70000, 0}, {40000, 40000}};
  for (int i = 0; i < 3; ++i) {
    VkCommandBuffer commands;
    OK(vkAllocateCommandBuffers(device,
                                &(VkCommandBufferAllocateInfo){VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                               .commandPool = commandPool, .commandBufferCount = 1},
                                &commands));
    OK(vkBeginCommandBuffer(commands, &(VkCommandBufferBeginInfo){VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO}));
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0, NULL);
    vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, 8, cases[i]);
    vkCmdDispatch(commands, 1, 1, 1);
    VkMemoryBarrier barrier = {VK_STRUCTURE_TYPE_MEMORY_BARRIER, .srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT,
                               .dstAccessMask = VK_ACCESS_HOST_READ_BIT};
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0,
                         NULL, 0, NULL);
    OK(vkEndCommandBuffer(commands));
    VkSubmitInfo submit = {VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &commands};
    OK(vkQueueSubmit(queue, 1, &submit, VK_NULL_HANDLE));
    VkResult result = vkQueueWaitIdle(queue);
    printf("loops of %u and %u turns: made %u and %u, result %d\n", cases[i][0], cases[i][1], counted[0], counted[1],
           result);
  }
  return 0;
}
C
glslangValidator -V --target-env vulkan1.2 --vn turns_spirv turns.comp -o turns.h >/dev/null
gcc -std=c11 -O1 turns.c -lvulkan -o turns
./turns >printed || exit 2
cat printed
sed 1d printed >counts
cat >described <<'E'
loops of 60000 and 0 turns: made 60000 and 0, result 0
loops of 70000 and 0 turns: made 65535 and 0, result 0
loops of 40000 and 40000 turns: made 40000 and 25534, result 0
E
cmp -s described counts || { echo "that is new: it was"; cat described; exit 1; }
