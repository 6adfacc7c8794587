#!/bin/sh
# A good engineer would guess: behind a loop that the lanes of a SIMD unit leave one by one, each lane has what it
# computed in its own last turn. Drivers mask lanes for that, and a variable that is assigned in every turn of a
# do-while loop and read behind it is the plainest case there is.
# What happens instead, on both Vulkan drivers for processors: where such a value was loaded from a buffer and the
# loop does not carry it from turn to turn, most lanes have 0: those that have left go through the other lanes' turns
# too, in which the load is masked for them. Only the lanes that leave last have what they loaded. Values that are
# computed are right here. All results are VK_SUCCESS, and the validation layers have nothing to say. A loop that
# tests its condition at its head is right on both: what leaves it was carried.
# Source: SPIR-V specification 2.2.5 and 2.11 (invocations, control flow): an invocation executes what it reaches
# itself.
# SwiftShader, src/Pipeline/SpirvShaderControlFlow.cpp, EmitLoop: it keeps each lane's value for phis alone.
# Seen: mesa-vulkan-drivers 22.3.6-1+deb12u2; chromium-common 156.0.8078.114-1~deb12u1. lavapipe of Mesa 25.0.7 (Debian
# 13) is right.
# Usage: findings/values_behind_divergent_loops.sh    exit code 0: as described; 1: no longer so; 2: something is missing
set -eu
for package in gcc libvulkan-dev glslang-tools mesa-vulkan-drivers chromium-common; do
  dpkg-query -W "$package" >/dev/null 2>&1 || { echo "missing: apt-get install $package" >&2; exit 2; }
done
echo "mesa-vulkan-drivers $(dpkg-query -W -f '${Version}' mesa-vulkan-drivers) (described: 22.3.6-1+deb12u2)"
echo "chromium-common $(dpkg-query -W -f '${Version}' chromium-common) (described: 156.0.8078.114-1~deb12u1)"
lavapipe=$(dpkg-query -L mesa-vulkan-drivers | grep '/lvp_icd.*json$')
swiftshader=$(dpkg-query -L chromium-common | grep '/vk_swiftshader_icd.json$')
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
cat >follow.comp <<'GLSL'
#version 450
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Buffer {
  uvec2 words[64];
  uint turns[64], loaded[64], squared[64], atHead[64];
};
void main() {
  uint lane = gl_LocalInvocationIndex, next = lane, left = turns[lane];
  uvec2 word;
  do {
    word = words[next];
    next = word.x;
    --left;
  } while (left > 0u);
  loaded[lane] = word.y;
  uint i = 0u, square;
  do {
    square = i * i + lane;
    ++i;
  } while (i < turns[lane]);
  squared[lane] = square;
  next = lane;
  left = turns[lane];
  uvec2 carried = uvec2(0u);
  while (left > 0u) {
    carried = words[next];
    next = carried.x;
    --left;
  }
  atHead[lane] = carried.y;
}
GLSL
cat >follow.c <<'C'
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <vulkan/vulkan.h>

#include "follow.h"

#define OK(call)                             \
  do {                                       \
    VkResult r = (call);                     \
    if (r) {                                 \
      fprintf(stderr, "%s: %d\n", #call, r); \
      exit(2);                               \
    }                                        \
  } while (0)

enum { kLanes = 64 };
struct Memory {
  uint32_t words[kLanes][2], turns[kLanes], loaded[kLanes], squared[kLanes], atHead[kLanes];
};

int main(void) {
  VkInstance instance;
  VkApplicationInfo application = {VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_2};
  OK(vkCreateInstance(&(VkInstanceCreateInfo){VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &application},
                      NULL, &instance));
  VkPhysicalDevice chosen;
  uint32_t count = 1;
  vkEnumeratePhysicalDevices(instance, &count, &chosen);  // the one that VK_DRIVER_FILES leaves
  if (count == 0) return 2;
  VkPhysicalDeviceDriverProperties driver = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
  VkPhysicalDeviceProperties2 properties = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &driver};
  vkGetPhysicalDeviceProperties2(chosen, &properties);

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
  VkBuffer buffer;
  OK(vkCreateBuffer(device,
                    &(VkBufferCreateInfo){VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = sizeof(struct Memory),
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
  struct Memory* all;
  OK(vkMapMemory(device, memory, 0, VK_WHOLE_SIZE, 0, (void**)&all));
  uint32_t random = 1;
  for (int i = 0; i < kLanes; ++i) {
    random = random * 1664525u + 1013904223u;
    all->words[i][0] = random >> 8 & 63;
    all->words[i][1] = 1000 + i;
    all->turns[i] = 1 + i * 5 % 7;
    all->loaded[i] = all->squared[i] = all->atHead[i] = 0;
  }

  VkDescriptorSetLayoutBinding binding = {0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, NULL};
  VkDescriptorSetLayout setLayout;
  OK(vkCreateDescriptorSetLayout(device,
                                 &(VkDescriptorSetLayoutCreateInfo){VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                                                    .bindingCount = 1, .pBindings = &binding},
                                 NULL, &setLayout));
  VkPipelineLayout layout;
  OK(vkCreatePipelineLayout(device,
                            &(VkPipelineLayoutCreateInfo){VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                                          .setLayoutCount = 1, .pSetLayouts = &setLayout},
                            NULL, &layout));
  VkShaderModule module;
  OK(vkCreateShaderModule(device,
                          &(VkShaderModuleCreateInfo){VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                                      .codeSize = sizeof follow_spirv, .pCode = follow_spirv},
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
  vkUpdateDescriptorSets(device, 1,
                         &(VkWriteDescriptorSet){VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, .dstSet = set,
                                                 .descriptorCount = 1,
                                                 .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                                 .pBufferInfo = &info},
                         0, NULL);
  VkCommandPool commandPool;
  OK(vkCreateCommandPool(device, &(VkCommandPoolCreateInfo){VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO}, NULL,
                         &commandPool));
  VkCommandBuffer commands;
  OK(vkAllocateCommandBuffers(device,
                              &(VkCommandBufferAllocateInfo){VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                             .commandPool = commandPool, .commandBufferCount = 1},
                              &commands));
  OK(vkBeginCommandBuffer(commands, &(VkCommandBufferBeginInfo){VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO}));
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0, NULL);
  vkCmdDispatch(commands, 1, 1, 1);
  VkMemoryBarrier barrier = {VK_STRUCTURE_TYPE_MEMORY_BARRIER, NULL, VK_ACCESS_SHADER_WRITE_BIT,
                             VK_ACCESS_HOST_READ_BIT};
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0,
                       NULL, 0, NULL);
  OK(vkEndCommandBuffer(commands));
  OK(vkQueueSubmit(queue, 1,
                   &(VkSubmitInfo){VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &commands},
                   VK_NULL_HANDLE));
  OK(vkQueueWaitIdle(queue));

  int wrongLoads = 0, wrongSquares = 0, wrongAtHead = 0;
  for (uint32_t i = 0; i < kLanes; ++i) {
    uint32_t at = i;
    for (uint32_t turn = 1; turn < all->turns[i]; ++turn) at = all->words[at][0];
    wrongLoads += all->loaded[i] != all->words[at][1];
    wrongAtHead += all->atHead[i] != all->words[at][1];
    wrongSquares += all->squared[i] != (all->turns[i] - 1) * (all->turns[i] - 1) + i;
  }
  printf("%s (%s): wrong are %d of %d values that were loaded, %d that were computed, "
         "%d by a loop that tests at its head\n",
         properties.properties.deviceName, driver.driverInfo, wrongLoads, kLanes, wrongSquares, wrongAtHead);
  return 0;
}
C
glslangValidator -V --target-env vulkan1.1 --vn follow_spirv -o follow.h follow.comp >/dev/null
gcc -std=c11 -o follow follow.c -lvulkan
for driver in "$lavapipe" "$swiftshader"; do
  found=$(VK_DRIVER_FILES=$driver ./follow)
  echo "$found"
  case $found in
    *": wrong are 0 of 64 values"*) echo "no longer so"; exit 1 ;;
    *" that were loaded, 0 that were computed, 0 by a loop that tests at its head") ;;
    *) echo "no longer so"; exit 1 ;;
  esac
done
