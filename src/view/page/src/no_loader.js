// Stands for the loaders of mesh files, which the page does not have.
export class STLLoader {}
export class ColladaLoader {}
