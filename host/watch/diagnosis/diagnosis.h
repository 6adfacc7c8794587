// Messages about the shaders' text, taken apart, given a column, and written as editors and terminals like them.
#pragma once

#include <string>
#include <vector>

#include "base/json_writer.h"
#include "kernel/shader_sources.h"

namespace turner::watch {

struct Diagnosis {
  std::string file;          // empty: the message is about no file
  int line = 0, column = 0;  // from 1, the column in bytes; 0: unknown
  std::string message;
  std::string source;  // text of that line
};

// One for each line of the text: "file:line:column: error: message", the same without a column or without a line, or
// any other text. The source's line comes from the sources, else from the disk. Where a line is known and no column,
// the column is deduced from what the message quotes.
std::vector<Diagnosis> readDiagnoses(const std::string& text, const std::vector<ShaderSource>& sources);

// As an array "diagnoses" of objects, into an object that is open.
void putDiagnoses(JsonWriter& json, const std::vector<Diagnosis>& diagnoses);

// "file:line:column: error: message", then the source's line and a caret below the place. No byte of it can do a
// terminal harm.
std::string gccText(const Diagnosis& diagnosis);

}  // namespace turner::watch
