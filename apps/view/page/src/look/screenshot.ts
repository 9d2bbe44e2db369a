// The picture as a file: mesh, legend and title on one canvas.
import type { SceneViewer } from '../scene/scene_viewer';
import type { Legend } from './legend';
import type { Palette } from './theme';

const margin = 20;

/** `scale`: pixels of the file for a pixel of the page. Lettering grows with it. */
export function compose(
  viewer: SceneViewer,
  legend: Legend,
  palette: Palette,
  size: { width: number; height: number; scale: number },
): Promise<Blob> {
  const { width, height, scale } = size;
  const canvas = document.createElement('canvas');
  canvas.width = width;
  canvas.height = height;
  const context = canvas.getContext('2d');
  if (!context) return Promise.reject(new Error('this browser draws no canvas'));
  // Twice as fine, as far as a canvas can be: edges are smooth whatever the graphics card does.
  const finer = Math.max(width, height) <= 4096 ? 2 : 1;
  viewer.stage.capture(width, height, finer, (picture) => {
    context.imageSmoothingQuality = 'high';
    context.drawImage(picture, 0, 0, width, height);
  });
  context.scale(scale, scale);
  legend.paint(context, viewer, margin, height / scale - margin);
  context.font = `600 14px ${getComputedStyle(document.body).fontFamily}`;
  context.textAlign = 'left';
  context.textBaseline = 'top';
  context.fillStyle = palette.text;
  context.fillText(viewer.mesh.name, margin, margin);
  return new Promise((resolve, reject) => {
    canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error('the picture is too large'))), 'image/png');
  });
}
