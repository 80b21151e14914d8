// The cell's z points up. Imported first: three.js reads it when objects are made.
import { Object3D } from "three";

Object3D.DEFAULT_UP.set(0, 0, 1);
