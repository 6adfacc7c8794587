// Linked with the whole of one room and the rooms and libraries that it names: what it uses besides is an undefined
// symbol.
int main() {
  return 0;
}
